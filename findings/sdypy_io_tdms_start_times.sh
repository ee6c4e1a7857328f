#!/usr/bin/env bash
# sdypy-io-tdms: a file that it writes has no start times and seven digits, one that it reads has whole seconds.
#
# Guess: write_tdms and read_tdms keep the start time of each signal, its offset, and the numbers as float64.
# Versions: sdypy-io-tdms 0.1.2, npTDMS 1.13.0, sdypy-sep005 1.0.1.
# Behaviour: write_tdms converts all data to float32 and writes no wf_start_time; the time of the file is a property "datestring"
#   of the root with the literal letter H in place of the hour. read_tdms cuts wf_start_time to whole seconds and does not read
#   wf_start_offset.
# Output: web length from 123 456 m on at 10 m/s and 1 kHz: the speed from differences is 7.8 or 15.6 m/s. Two signals that
#   start 12 s apart: written, both start at 0. A file by npTDMS with channels that start 0.2 s apart, at 10:00:00.9 and
#   10:00:01.1: read as 1 s apart.
# Documented: not found.
# Why it matters: the file is valid, and a reader can only join the channels as if they had started together, as woundon
#   does: tension against the radius is shifted by the seconds between the starts of the recorders.
# Remedy: nptdms.TdmsWriter with wf_start_time for each channel.
. "$(dirname "$0")/environment" sdypy-io-tdms==0.1.2 sdypy-sep005==1.0.1 npTDMS==1.13.0 numpy==2.4.6
python -W ignore - <<'EOF'
import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter
from sdypy_io_tdms.tdms import read_tdms, write_tdms

length = 123_456.0 + 0.01 * np.arange(1000)
starts = "2026-01-01 10:00:00", "2026-01-01 10:00:12"
signals = [
    {"group": "log", "name": name, "unit_str": "m", "data": length, "fs": 1000.0, "start_timestamp": start}
    for name, start in zip(("length", "other"), starts)
]
write_tdms(signals, "log.tdms")
file = TdmsFile.read("log.tdms")
channel = file["log"]["length"]
speeds = np.unique(np.round(np.diff(channel[:].astype(float)) * 1000, 1))
properties = {name for channel in file["log"].channels() for name in channel.properties}
print(channel.dtype, "speeds", speeds, "properties", properties, file.properties["datestring"])
if channel.dtype != np.float32 or speeds.tolist() != [7.8, 15.6] or "wf_start_time" in properties:
    raise SystemExit(f"changed: {channel.dtype}, {speeds}, {properties}")
if " H:" not in file.properties["datestring"]:
    raise SystemExit(f"changed: {file.properties}")

with TdmsWriter("two.tdms") as writer:
    for name, start in (("fast", "2026-01-01T10:00:00.900"), ("slow", "2026-01-01T10:00:01.100")):
        times = {"wf_start_time": np.datetime64(start), "wf_start_offset": 0.0, "wf_increment": 1e-3}
        writer.write_segment([ChannelObject("log", name, length, times)])
exact = [channel.properties["wf_start_time"] for channel in TdmsFile.read("two.tdms")["log"].channels()]
read = [np.datetime64(signal["start_timestamp"]) for signal in read_tdms("two.tdms")]
apart = [(pair[1] - pair[0]) / np.timedelta64(1, "s") for pair in (exact, read)]
print("npTDMS, sdypy-io-tdms: start times apart by", apart)
if apart != [0.2, 1.0]:
    raise SystemExit(f"changed: {apart}")
print("as stated")
EOF
