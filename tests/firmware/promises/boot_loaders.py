"""Boot loaders as a program meets them: what they leave of the cause of a reset."""

# What a boot loader does before it jumps to the program at 0; its version is the flash's last byte.
# Optiboot 5 hands the reset's flags on in r2. Arduino's Nano comes with Optiboot 4.4, the Mega with
# another: both clear the flags.
HANDS_ON = bytes.fromhex("1124 84b7 282e 14be 0c94 0000")  # r2 = MCUSR, MCUSR = 0
HIDES = bytes.fromhex("1124 81e0 282e 14be 0c94 0000")  # r2 = 1, which is nothing; MCUSR = 0
LOADERS = {
    "Optiboot 4.4": HIDES.ljust(510, b"\xff") + b"\4\4",
    "Optiboot 5.0": HANDS_ON.ljust(510, b"\xff") + b"\0\5",
    "without a version": HIDES.ljust(512, b"\xff"),
}
