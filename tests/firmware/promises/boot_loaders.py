"""Boot loaders as a program meets them: what they leave of the cause of a reset."""

# What a boot loader does before it jumps to the program at 0; its version is the flash's last byte.
# Optiboot 5 hands the reset's flags on in r2; but after an external reset it waits for a program,
# and then lets its watchdog start this one. From version 7 on it adds that flag to the external
# one.
# Arduino's Nano comes with Optiboot 4.4, the Mega with another: both clear the flags.
FIVE = bytes.fromhex("1124 84b7 81fd 88e0 282e 14be 0c94 0000")  # r2 = EXTRF ? WDRF : MCUSR
SEVEN = bytes.fromhex("1124 84b7 81fd 8ae0 282e 14be 0c94 0000")  # … EXTRF | WDRF …
HIDES = bytes.fromhex("1124 81e0 282e 14be 0c94 0000")  # r2 = 1, which is nothing; MCUSR = 0
LOADERS = {
    "Optiboot 4.4": HIDES.ljust(510, b"\xff") + b"\4\4",
    "Optiboot 5.0": FIVE.ljust(510, b"\xff") + b"\0\5",
    "Optiboot 7.0": SEVEN.ljust(510, b"\xff") + b"\0\7",
    "without a version": HIDES.ljust(512, b"\xff"),
}
