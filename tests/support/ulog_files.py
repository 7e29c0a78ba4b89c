"""ULog files of a made-up flight, written after the format's specification."""

import struct

import numpy as np
from scipy.spatial.transform import Rotation

EPOCH_S = 1435728600.0  # 2015-07-01T05:30:00Z
EULER_DEG = np.array([[200.0, -20.0, 30.0], [10.0, 5.0, -40.0], [359.0, 60.0, 100.0]])  # yaw first


def quaternions(count):
    picked = EULER_DEG[np.arange(count) % len(EULER_DEG)]
    x, y, z, w = Rotation.from_euler("ZYX", picked, degrees=True).as_quat().T
    return np.array([w, x, y, z])


def topics(*, old_position=False):
    """Twelve seconds at 2 Hz, booted 100 s before the first sample."""
    micros = (100_000_000 + 500_000 * np.arange(24)).astype(np.uint64)
    full = np.ones(24)
    position = {
        "timestamp": micros,
        "time_utc_usec": ((EPOCH_S - 100.0) * 1e6 + micros).astype(np.uint64),
        "fix_type": np.full(24, 3, np.uint8),
    }
    if old_position:
        position["lat"] = (476000000 * full).astype(np.int32)
        position["lon"] = (85300000 * full).astype(np.int32)
        position["alt"] = (536000 * full).astype(np.int32)
    else:
        position |= {"latitude_deg": 47.6 * full, "longitude_deg": 8.53 * full}
        position["altitude_msl_m"] = 536.0 * full
    attitude = {"timestamp": micros} | {f"q[{i}]": q for i, q in enumerate(quaternions(24))}
    power = {"timestamp": micros}
    power |= {f"mppt_volt[{i}]": volt * full for i, volt in enumerate((20.0, 22.0, 0.0))}
    power |= {f"mppt_amp[{i}]": current * full for i, current in enumerate((2.0, 3.0, 0.0))}
    battery = {"timestamp": micros, "voltage_v": 24.0 * full, "current_a": 2.0 * full}
    battery["remaining"] = np.where(np.arange(24) < 4, -1.0, 0.8)
    return {
        "sensor_mppt": power,
        "vehicle_attitude": attitude,
        "vehicle_gps_position": position,
        "battery_status": battery,
    }


def ulog_bytes(content):
    """ULog file after the format's specification: header, definitions, data."""
    types = {"u8": ("uint64_t", "Q"), "u1": ("uint8_t", "B"), "i4": ("int32_t", "i")}
    types |= {"f8": ("float", "f")}
    out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    messages = []
    tail = []
    for number, (name, fields) in enumerate(content.items()):
        kinds = [np.asarray(v).dtype.str[1:] for v in fields.values()]
        names = [n.replace("[", "_").replace("]", "") for n in fields]
        arrays = [n.split("[")[0] for n in fields if "[" in n]
        spelled = []
        for field, plain, kind in zip(fields, names, kinds, strict=True):
            base = field.split("[")[0]
            if base in arrays:
                if field.endswith("[0]"):
                    spelled.append(f"{types[kind][0]}[{arrays.count(base)}] {base}")
            else:
                spelled.append(f"{types[kind][0]} {plain}")
        messages.append((b"F", f"{name}:{';'.join(spelled)};".encode()))
        tail.append((b"A", struct.pack("<BH", 0, number) + name.encode()))
        layout = "<" + "".join(types[kind][1] for kind in kinds)
        for values in zip(*(np.asarray(v).tolist() for v in fields.values()), strict=True):
            tail.append((b"D", struct.pack("<H", number) + struct.pack(layout, *values)))
    for kind, body in (*messages, *tail):
        out += struct.pack("<H", len(body)) + kind + body
    return out
