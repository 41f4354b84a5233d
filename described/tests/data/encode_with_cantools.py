#!/usr/bin/env python3
"""Writes cantools.dbc and cantools.csv: random layouts, and what cantools encodes with them.

usage: encode_with_cantools.py     (needs cantools; writes beside itself)
"""

import csv
import pathlib
import random

import cantools

HERE = pathlib.Path(__file__).parent
MESSAGES = 40
FRAMES = 5
random.seed(20)


def bits(start, length, big):
    """The bits of a signal, numbered as in a DBC."""
    if not big:
        return [start + index for index in range(length)]
    along = 8 * (start // 8) + 7 - start % 8
    return [8 * (bit // 8) + 7 - bit % 8 for bit in range(along, along + length)]


def signals(length_bytes=8):
    """Signals of one message that share no bit, and the limits of their counts."""
    taken, lines, floats, limits = set(), [], [], {}
    for _ in range(30 * length_bytes // 8):
        is_float = random.random() < 0.1
        length = random.choice([32, 64]) if is_float else random.randint(1, 40)
        big, signed = random.random() < 0.5, is_float or random.random() < 0.5
        start = random.randint(0, 8 * length_bytes - 1)
        wanted = bits(start, length, big)
        if max(wanted) >= 8 * length_bytes or taken.intersection(wanted):
            continue
        taken.update(wanted)
        name = f"s{len(lines)}"
        factor, offset = random.choice([(1, 0), (0.5, -40), (0.01, 0), (-2, 100)])
        if is_float:
            factor, offset = 1, 0
            floats.append((name, length // 32))
        sign = "-" if signed else "+"
        lines.append(
            f" SG_ {name} : {start}|{length}@{0 if big else 1}{sign} ({factor},{offset}) [0|0] \"\" B"
        )
        least = -(1 << (length - 1)) if signed else 0
        limits[name] = (least, least + (1 << length) - 1, factor, offset, is_float)
    return lines, floats, limits


def multiplexed(index, identifier):
    """A message whose multiplexer has another below it, with numbers and ranges; and its lines of SG_MUL_VAL_."""
    big = random.random() < 0.5
    # Eight bits each, wherever the byte order has them.
    place = lambda byte: f"{8 * byte + 7}|8@0" if big else f"{8 * byte}|8@1"
    lines = [f" SG_ top M : {place(0)}+ (1,0) [0|0] \"\" B", f" SG_ low m1M : {place(1)}+ (1,0) [0|0] \"\" B"]
    tail = f"SG_MUL_VAL_ {identifier} low top 1-1;\n"
    limits = {"top": (0, 255, 1, 0, False), "low": (0, 255, 1, 0, False)}
    for number in range(random.randint(2, 6)):
        name, of = f"s{number}", random.choice(["top", "low"])
        first = 10 * number + 2
        last = first + random.choice([0, 0, 4])
        sign = random.choice("+-")
        factor, offset = random.choice([(1, 0), (0.5, -40), (0.01, 0), (-2, 100)])
        lines.append(f" SG_ {name} m{first} : {place(2 + number % 3)}{sign} ({factor},{offset}) [0|0] \"\" B")
        tail += f"SG_MUL_VAL_ {identifier} {name} {of} {first}-{last}" + random.choice(["", f", {last + 3}-{last + 3}"]) + ";\n"
        least = -128 if sign == "-" else 0
        limits[name] = (least, least + 255, factor, offset, False)
    lines.append(f" SG_ always : {place(7)}+ (1,0) [0|0] \"\" B")
    limits["always"] = (0, 255, 1, 0, False)
    text = f"BO_ {identifier} X{index}: 8 A\n" + "\n".join(lines) + "\n\n"
    return text, tail, limits


def frames(message, limits):
    """Values of frames of each kind that a multiplexed message has."""
    numbers = lambda name: sorted({n for s in message.signals if s.multiplexer_signal == name for n in s.multiplexer_ids})
    for top in numbers("top"):
        for low in numbers("low") if top == 1 else [0]:
            values = {name: random.randint(least, greatest) * factor + offset
                      for name, (least, greatest, factor, offset, _) in limits.items()}
            # What the frame has is for cantools to say.
            yield message.gather_signals({**values, "top": top, "low": low})


def main():
    text = 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A B\n\n'
    tail, all_limits = "", {}
    for index in range(MESSAGES):
        lines, floats, limits = signals()
        identifier = index + 1 if index % 2 else (1 << 31) + 0x10000 + index
        text += f"BO_ {identifier} M{index}: 8 A\n" + "\n".join(lines) + "\n\n"
        for name, kind in floats:
            tail += f"SIG_VALTYPE_ {identifier} {name} : {kind};\n"
        all_limits[f"M{index}"] = limits
    state = random.getstate()
    random.seed(21)
    formats = ["StandardCAN_FD", "ExtendedCAN_FD"]
    tail += 'BA_DEF_ BO_ "VFrameFormat" ENUM ' + ",".join(f'"{name}"' for name in ["StandardCAN", *formats]) + ";\n"
    tail += 'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";\n'
    for index, length in enumerate([8, 12, 16, 20, 24, 32, 48, 64]):
        lines, floats, limits = signals(length)
        identifier = 1200 + index if index % 2 else (1 << 31) + 0x20000 + index
        text += f"BO_ {identifier} F{index}: {length} A\n" + "\n".join(lines) + "\n\n"
        for name, kind in floats:
            tail += f"SIG_VALTYPE_ {identifier} {name} : {kind};\n"
        tail += f'BA_ "VFrameFormat" BO_ {identifier} {1 if index % 2 else 2};\n'
        all_limits[f"F{index}"] = limits
    random.setstate(state)
    groups = {}
    for index in range(12):
        lines, more, groups[f"X{index}"] = multiplexed(index, 1000 + index)
        text += lines
        tail += more
    text += tail
    (HERE / "cantools.dbc").write_text(text)
    database = cantools.database.load_string(text, "dbc")
    with open(HERE / "cantools.csv", "w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["message", "data", "values"])
        for name, limits in all_limits.items():
            for _ in range(FRAMES):
                values = {}
                for signal, (least, greatest, factor, offset, is_float) in limits.items():
                    if is_float:
                        values[signal] = random.randint(-1000, 1000) / 8
                    else:
                        count = random.choice([least, greatest, random.randint(least, greatest)])
                        values[signal] = count * factor + offset
                data = database.encode_message(name, values)
                row = " ".join(f"{signal}={value!r}" for signal, value in values.items())
                rows.writerow([name, data.hex(), row])

        for name, limits in groups.items():
            message = database.get_message_by_name(name)
            # A multiplexer without signals below it would be asked for a number that it does not have.
            if not any(signal.multiplexer_signal == "low" for signal in message.signals):
                continue
            for values in frames(message, limits):
                data = message.encode(values)
                row = " ".join(f"{signal}={value!r}" for signal, value in values.items())
                rows.writerow([name, data.hex(), row])


if __name__ == "__main__":
    main()
