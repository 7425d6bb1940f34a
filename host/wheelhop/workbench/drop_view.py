"""Where recordings are dropped, one by one or as a whole folder."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui
from nicegui.events import UploadEventArguments

from wheelhop.workbench.view import html

ENDINGS = (
    *(".csv", ".txt", ".tsv", ".dat", ".asc", ".mf4", ".tdms", ".uff", ".unv", ".lvm", ".hop"),
    *(".parquet", ".mdf", ".log", ".vbo", ".mat", ".h5", ".hdf5", ".ide", ".mcap", ".bag", ".db3"),
    *(".xrk", ".xrz"),
)
TAKEN = (
    "CSV or text of any layout, MDF, TDMS, UFF, LVM, Parquet, MATLAB, HDF5, VBOX, AiM, enDAQ, ROS"
    " bags, MCAP, or the logger's .HOP. They hold accelerations of axles or body, travel, rates,"
    " forces."
)
DROPPED = f"""(event) => wheelhop.filesOf(event.dataTransfer, {list(ENDINGS)}).then(
  (files) => runMethod(ID, 'addFiles', [files]))"""
FOLDER = f"""() => wheelhop.chooseFolder({list(ENDINGS)},
  (files) => runMethod(ID, 'addFiles', [files]))"""


def drop_area(
    take: Callable[[UploadEventArguments], Awaitable[None]], say: Callable[[str], None]
) -> None:
    """A place to drop files, or to choose them; `take` gets each that was uploaded."""
    upload = ui.upload(multiple=True, auto_upload=True, on_upload=take)
    upload.on("rejected", lambda: say(f"A file was not taken. Taken are: {TAKEN}"))
    upload.props(f'accept="{",".join(ENDINGS)}"').classes("hidden")
    button = ui.element("button").classes("bench-drop")
    button.on("click", js_handler=f"() => runMethod({upload.id}, 'pickFiles', [])")
    button.on("dragover.prevent", js_handler="() => {}")
    button.on("drop.prevent", js_handler=DROPPED.replace("ID", str(upload.id)))
    with button:
        html("<strong>Drop recordings here, or a whole folder; or press to choose</strong>")
        ui.label(TAKEN)
    whole = ui.button("Choose a whole folder").props("flat dense no-caps")
    whole.on("click", js_handler=FOLDER.replace("ID", str(upload.id)))
