"""The workbench: compare, see, learn, add, and watch the error fall, in the user's browser.

The page's process holds what is shown, plain numbers and finished drawings (`shown`); everything
that computes runs in a second process (`worker`), so that the page answers at once and the work can
be given up at once. Between them stands the `desk`: what the user decided, and what is known.
"""
