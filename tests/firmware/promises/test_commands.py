"""Whatever is sent as commands, the logger does what SPEC.md says and keeps its totals.

A model of the settings walks beside the real firmware: what is answered with `K` is so, what is
answered with `E` has changed nothing.
"""

import binascii
import re
import string

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from tests.firmware.promises.logger import Logger, configure
from wheelhop.hil_sim import CardImage

PLAIN = "".join(map(chr, range(0x20, 0x7F)))
BLANKS = b" \t"
LONGEST = 59  # characters of a line
CONVERSIONS = {"100": "8", "200": "4", "400": "2"}
WORDS = ("start", "stop", "status", "info", "list", "reset", "stream on", "stream off")
KNOWN = ("rate", "channels", "name", "start", "stream", "size_mb")
KNOWN += ("device", "calibration", "clock_ppm")


def near(least, most):
    """Numbers within bounds, at them, and just outside."""
    return st.integers(least, most) | st.sampled_from([least - 1, least, most, most + 1])


text = st.text(PLAIN, max_size=20)
names = st.lists(
    st.text(string.ascii_letters + string.digits + "_", min_size=1, max_size=4) | st.just("-"),
    min_size=8,
    max_size=8,
)
good = st.one_of(
    st.tuples(st.just("rate"), st.sampled_from(sorted(CONVERSIONS))),
    st.tuples(st.just("channels"), names.map(" ".join)),
    st.tuples(st.sampled_from(["name", "calibration"]), text),
    st.tuples(st.just("device"), near(0, 65534).map(str)),
    st.tuples(st.just("clock_ppm"), near(-20_000, 20_000).map(str)),
)
wild = st.tuples(st.sampled_from(KNOWN) | text, text)


def is_allowed(key, value):
    """Whether SPEC.md gives this value to this key; of those that `info` shows."""
    if key == "rate":
        return value in CONVERSIONS
    if key == "channels":
        words = value.split(" ")
        used = [word for word in words if word != "-"]
        plain = all(re.fullmatch(r"\w{1,4}", word, re.ASCII) for word in used)
        return len(words) == 8 and bool(used) and plain and len(set(used)) == len(used)
    if key in ("name", "calibration"):
        return len(value) <= 15
    if key == "device":
        return 0 <= int(value) <= 65534
    return abs(int(value)) <= 20_000


class Conversation(RuleBasedStateMachine):
    """One logger's life, from power-up."""

    elf, folder = None, None  # given by the test

    def __init__(self):
        super().__init__()
        path = self.folder / "card.img"
        path.unlink(missing_ok=True)
        self.one = Logger(self.elf, configure(CardImage.fat32(path), "size_mb = 1\n"))
        self.one.boot()
        self.running = False
        self.info = self.read_info()

    def read_info(self):
        """The settings, as `info` shows them."""
        values = self.one.command("info").values
        keys = ("rate_hz", "conversions", "channels", "name", "device", "calibration", "clock_ppm")
        return {key: values[key] for key in keys}

    def answer(self, line):
        """Send a line; its one answer."""
        begin = len(self.one.frames)
        self.one.board.serial.write(line)
        self.one.run(0.15)
        answers = [frame for frame in self.one.frames[begin:] if frame.kind in "KE"]
        assert len(answers) == 1, (line, answers)
        return answers[0].kind == "K"

    @rule(setting=good, checked=st.booleans())
    def set_what_is_known(self, setting, checked):
        key, value = setting
        command = f"set {key}={value}"
        if not checked and "*" in command:
            return  # only with a check sum
        sum_ = f"*{binascii.crc_hqx(command.encode(), 0):04X}" if checked else ""
        if len(command) + len(sum_) > LONGEST:
            return
        value = value.strip(" ")
        wanted = is_allowed(key, value) and (key == "clock_ppm" or not self.running)
        assert self.answer(f"{command}{sum_}\n".encode()) == wanted
        if wanted:
            self.info["rate_hz" if key == "rate" else key] = value
            self.info["conversions"] = CONVERSIONS[self.info["rate_hz"]]
            if key == "clock_ppm":
                self.info[key] = str(int(value))

    @rule(setting=wild)
    def set_anything(self, setting):
        line = f"set {setting[0]}={setting[1]}"
        if "*" in line or len(line) > LONGEST:
            return
        if self.answer(line.encode() + b"\n"):
            assert setting[0].strip(" ") in KNOWN
            self.info = self.read_info()

    @rule(line=st.binary(max_size=120))
    def send_bytes(self, line):
        line = line.translate(None, b"\n\r").strip(BLANKS)
        # A "#" behind noise alone makes a comment, too.
        comment = re.match(rb"[^!-~]*#", line)
        if not line or comment or line.decode("latin1") in WORDS:
            return
        assert not self.answer(line + b"\n")

    @rule(word=st.sampled_from(WORDS), at=st.integers(0, 9), to=st.sampled_from(PLAIN))
    def damage_a_command(self, word, at, to):
        line = f"{word}*{binascii.crc_hqx(word.encode(), 0):04X}"
        at %= len(line)
        damaged = line[:at] + to + line[at + 1 :]
        if damaged.upper() == line.upper() or "*" not in damaged or damaged[0] in "# ":
            return
        assert not self.answer(damaged.encode() + b"\n")

    @rule()
    def start(self):
        assert self.one.command("start").ok
        self.running = True

    @rule(seconds=st.sampled_from([0.01, 0.3, 1.0]))
    def wait(self, seconds):
        self.one.run(seconds)

    @rule(on=st.sampled_from(["on", "off"]))
    def stream(self, on):
        assert self.one.command(f"stream {on}").ok

    @rule(block=near(0, 12), count=near(0, 3), name=st.sampled_from(["HOP00001.HOP", "hop1.hop"]))
    def get(self, block, count, name):
        begin = len(self.one.frames)
        reply = self.one.command(f"get {name} {block} {count}")
        pieces = [frame.payload[4:] for frame in self.one.frames[begin:] if frame.kind == "F"]
        there = not self.running and name in self.one.card.files()
        assert reply.ok == (there and block >= 0 and count >= 1)
        if reply.ok:
            data = self.one.card.read(name)
            assert int(reply.text) == len(data)
            assert b"".join(pieces) == data[512 * block :][: 512 * count]

    @rule(words=text)
    def get_anything(self, words):
        if "*" not in words:
            self.answer(f"get {words}\n".encode())

    @rule()
    def list_files(self):
        reply = self.one.command("list")
        files = self.one.card.files().items()
        logs = [f"{name} {size}" for name, size in files if name.endswith(".HOP")]
        assert (reply.ok, reply.lines) == ((False, []) if self.running else (True, logs))

    @precondition(lambda self: self.running)
    @rule()
    def stop(self):
        assert self.one.command("stop").ok
        self.running = False
        log = self.one.log()
        assert sorted(log.scans) == list(range(int(log.summary["due"])))
        assert log.summary["lost"] == "0"
        assert log.header["channels"] == self.info["channels"]
        assert log.header["rate_hz"] == self.info["rate_hz"]

    @invariant()
    def the_settings_are_as_answered(self):
        assert self.read_info() == self.info

    @invariant()
    def the_state_is_as_told(self):
        state = self.one.command("status").values["state"]
        assert state == ("recording" if self.running else "ready")
        counters = self.one.board.counters()
        assert counters.resets == 0 and counters.card_violations == 0

    def teardown(self):
        self.one.board.close()


def test_the_logger_does_what_it_answers(elf, tmp_path):
    class Here(Conversation):
        folder = tmp_path

    Here.elf = elf
    run_state_machine_as_test(
        Here,
        settings=settings(
            max_examples=25,
            report_multiple_bugs=False,
            stateful_step_count=15,
            suppress_health_check=list(HealthCheck),
            database=None,
        ),
    )
