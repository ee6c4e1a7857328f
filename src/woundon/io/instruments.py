"""Read the channels of instrument files: LabVIEW measurement files (.lvm) and TDMS.

The channels of an instrument may have different rates.  Channels of one rate are the columns of one
table.  Others are joined by time, never by the number of the sample: to each instant of the slowest
channel that is used belongs the nearest sample of every other channel, at most half a period of
that channel away.  A channel whose start is not known, among others whose start is, is joined by
the number of the sample to one of its size and rate only.  Channels without a known name are not
read.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, one_of
from .table_files import check_column, decoded, sheet_name

__all__ = ["ENDINGS", "Channel", "Channels", "joined", "need_reader", "read_channels"]

Array = np.ndarray

ENDINGS = {".lvm": "lvmio", ".tdms": "nptdms"}  # ending of a file -> the package that reads it
ALL = "all"  # name of all segments or groups
MAX_SAMPLES = 50_000_000  # of all channels
ROUNDING = 1e-6  # relative differences of periods, and of instants to a period
NO_START = np.datetime64("1904-01-01", "us")  # zero of the clock of TDMS


class Channel(NamedTuple):
    """A channel of an instrument.

    Attributes
    ----------
    name, unit : str
    values : (n,) array
        nan where a sample is missing.
    start, period : float
        Instant of the first sample and time between two samples [s]; nan if they are not known.
    """

    name: str
    unit: str
    values: Array
    start: float
    period: float

    @property
    def time(self) -> Array:
        """The instants of the samples [s], (n,)."""
        return self.start + self.period * np.arange(self.values.size)

    def has_times_of(self, other: Channel) -> bool:
        """Return True if both channels have samples at the same instants, as far as is known."""
        if self.values.size != other.values.size:
            return False
        if np.isnan(self.period) or np.isnan(other.period):
            return bool(np.isnan(self.period) and np.isnan(other.period))
        limit = ROUNDING * self.period
        other_start = abs(self.start - other.start) > limit  # False for nan
        return not other_start and abs(self.period - other.period) * self.values.size <= limit


class Channels(NamedTuple):
    """The channels of a file as the columns of a table.

    Attributes
    ----------
    where : str
        Path of the file with the name of the segment or group.
    columns : dict of str to (rows,) array
        By the name of the channel.
    units : dict of str to str
    rows : int
        Number of rows.
    others : str
        Text on the other segments or groups of the file.
    remarks : tuple of str
        How the channels were joined.
    """

    where: str
    columns: dict[str, Array]
    units: dict[str, str]
    rows: int
    others: str = ""
    remarks: tuple[str, ...] = ()


def need_reader(ending: str) -> None:
    """Reject an instrument file if the package that reads it is not installed."""
    found = {".lvm": find_spec("lvmio"), ".tdms": find_spec("nptdms")}[ending]
    if found is None:
        text = f"{ending} files need {ENDINGS[ending]}: pip install 'woundon[instruments]'"
        raise InvalidProblem.at(ending[1:], text)


def read_channels(
    content: bytes, path: str, ending: str, sheet: str, is_known: Callable[[str], bool]
) -> Channels:
    """Return the channels of a segment of a .lvm file, or of a group of a .tdms file.

    Parameters
    ----------
    content : bytes
    path, ending : str
        Name of the file in error messages, and its ending.
    sheet : str
        Number of the segment or name of the group; may be empty if the file has only one.  "all"
        reads all of them, which must have the same channels, one after the other.
    is_known : callable
        Whether a header, with its unit, is a known name: the channels that are used.

    Raises
    ------
    InvalidProblem
        If the file is damaged, has several segments or groups and none is named, or if its channels
        cannot be joined.
    """
    tables = _lvm_segments(content, path) if ending == ".lvm" else _tdms_groups(content, path)
    word = "segments" if ending == ".lvm" else "groups"
    if not tables:
        text = "has no channel with numbers; if it should have some, copy the file again"
        raise InvalidProblem.at(path, text)
    names = tuple(tables)
    paths = one_of([f"{path}#{name}" for name in names], "and")
    if not sheet and len(names) > 1:
        text = f"has {len(names)} {word}, each a table; name one of {paths}"
        raise InvalidProblem.at(path, f"{text}; {path}#{ALL} reads them one after the other")
    if sheet.casefold() == ALL and ALL not in names:
        channels = _one_after_the_other(list(tables.values()), path)
        found = joined(channels, f"{path}#{ALL}", is_known)
        remark = f"{len(names)} {word} are read one after the other, without their times"
        return found._replace(remarks=(remark, *found.remarks))
    name = sheet_name(sheet, names, path)
    where = f"{path}#{name}" if len(names) > 1 else path
    others = f"other {word} are those of {paths}" if len(names) > 1 else ""
    return joined(tables[name], where, is_known)._replace(others=others)


def _one_after_the_other(tables: Sequence[Sequence[Channel]], where: str) -> list[Channel]:
    """Return the channels of several tables with all their samples, without times.

    Raises
    ------
    InvalidProblem
        If the tables have not the same channels, with the same units.
    """
    first = [(channel.name, channel.unit) for channel in tables[0]]
    for table in tables[1:]:
        if [(channel.name, channel.unit) for channel in table] != first:
            text = "has tables with different channels, which cannot be read one after the other"
            raise InvalidProblem.at(where, f"{text}; name one of them")
    return [
        Channel(name, unit, np.concatenate([table[k].values for table in tables]), 0.0, np.nan)
        for k, (name, unit) in enumerate(first)
    ]


def joined(channels: Sequence[Channel], where: str, is_known: Callable[[str], bool]) -> Channels:
    """Return channels as columns of one table, joined by time if their rates differ.

    Parameters
    ----------
    channels : sequence of Channel
        At least one.
    where : str
        Name of the table in error messages.
    is_known : callable
        Channels with other names are left out, if any channel has a known name.

    Raises
    ------
    InvalidProblem
        For two channels of one name, channels of different lengths or rates without times, and
        channels without a common instant.

    Examples
    --------
    >>> fast = Channel("Force", "N", np.arange(5.0), 0.0, 0.1)
    >>> slow = Channel("Weg", "mm", np.array([7.0, 8.0, 9.0]), 0.0, 0.2)
    >>> joined([fast, slow], "rig.tdms", lambda name: True).columns
    {'time': array([0. , 0.2, 0.4]), 'Force': array([0., 2., 4.]), 'Weg': array([7., 8., 9.])}
    """
    for k, channel in enumerate(channels):
        check_column(k + 1, where)
        if channel.name in [other.name for other in channels[:k]]:
            raise InvalidProblem.at(where, f"two channels have the name {channel.name!r}")
    used = [channel for channel in channels if is_known(f"{channel.name} [{channel.unit}]")]
    is_time_used = is_known("time [s]") or not used
    used = used or list(channels)
    # the slowest channel, preferably one whose start is known, and the shortest one of these
    base = max(used, key=lambda each: (each.period, not np.isnan(each.start), -each.values.size))
    remarks: list[str] = []
    columns: dict[str, Array] = {}
    has_all = np.ones(base.values.size, dtype=bool)  # whether every channel has a sample
    for channel in used:
        columns[channel.name] = channel.values
        if not channel.has_times_of(base):
            columns[channel.name], is_there = _at_times_of(base, channel, where)
            has_all &= is_there
            remarks.append(f"{channel.name!r}, one sample each {channel.period:.4g} s")
    if remarks:
        text = f"joined by time to {base.name!r}, one sample each {base.period:.4g} s: "
        remarks = [text + "; ".join(remarks)]
        if not has_all.all():
            _check_common_instants(base, has_all, where)
            count = int(np.count_nonzero(~has_all))
            remarks.append(f"{count} instants left out, at which a channel has no sample")
    unknown = [repr(each.name) for each in used if each is not base and np.isnan(each.start)]
    if unknown:
        text = f"the file does not state the start of {one_of(unknown, 'and')}; joined to "
        remarks.append(f"{text}{base.name!r} by the number of the sample")
    names = {channel.name for channel in used}
    missing = [channel.name for channel in channels if channel.name not in names]
    if missing:
        remarks.append(f"channels without a known name are not read: {', '.join(missing)}")
    has_times = is_time_used and not np.isnan(base.period) and not _has_time(columns)
    times = {"time": base._replace(start=np.nan_to_num(base.start)).time} if has_times else {}
    columns = {name: values[has_all] for name, values in (times | columns).items()}
    units = {channel.name: channel.unit for channel in used} | dict.fromkeys(times, "s")
    return Channels(where, columns, units, int(has_all.sum()), remarks=tuple(remarks))


def _at_times_of(base: Channel, channel: Channel, where: str) -> tuple[Array, Array]:
    """Return the samples of a channel nearest to the instants of another one, and where they exist.

    A sample exists if it is at most half a period of its channel away.  Both arrays have the size
    of ``base``, the other channel.
    """
    for each in (base, channel):
        if np.isnan(each.period):
            text = f"the channel {each.name!r} has no times, so that it cannot be joined to others"
            counts = f"{base.name!r} has {base.values.size} samples, {channel.name!r}"
            remedy = f"{counts} {channel.values.size}; export them with one rate"
            raise InvalidProblem.at(where, f"{text}: {remedy}")
        if np.isnan(each.start):
            sizes = " and ".join(
                f"{c.name!r} has {c.values.size} samples, one each {c.period:.4g} s"
                for c in (base, channel)
            )
            text = f"does not state when the channel {each.name!r} starts, so that it cannot be "
            text += f"joined to others of another size or rate: {sizes}; export them with one rate"
            raise InvalidProblem.at(where, text)
    number = np.rint((base.time - channel.start) / channel.period).astype(int)
    inside = (number >= 0) & (number < channel.values.size)
    return channel.values[np.clip(number, 0, channel.values.size - 1)], inside


def _check_common_instants(base: Channel, has_all: Array, where: str) -> None:
    """Reject channels that have samples at no common instant.

    Parameters
    ----------
    base : Channel
    has_all : (n,) bool array
        Instants of ``base`` at which every channel has a sample.
    where : str
    """
    if not has_all.any():
        first, last = base.time[[0, -1]]
        text = f"at no instant of {base.name!r}, {first:.6g} s to {last:.6g} s, does every channel "
        raise InvalidProblem.at(where, f"{text}have a sample; they were started at other times")


def _has_time(columns: dict[str, Array]) -> bool:
    """Return True if a channel has the name of the column of the instants."""
    return any(name.casefold() == "time" for name in columns)


def _lvm_segments(content: bytes, where: str) -> dict[str, list[Channel]]:
    """Return the channels of each segment of a .lvm file, by the number of the segment."""
    import lvmio

    try:
        file = lvmio.parse_lvm(decoded(content, where))
    except lvmio.LvmError as fault:
        raise InvalidProblem.at(where, f"is not a .lvm file that can be read: {fault}") from None
    return {
        str(number): [
            Channel(
                channel.name,
                channel.unit,
                np.array(channel.data, dtype=float),
                channel.x0,
                channel.delta_x,
            )
            for channel in segment
        ]
        for number, segment in enumerate(file, 1)
        if segment.channels
    }


def _tdms_groups(content: bytes, where: str) -> dict[str, list[Channel]]:
    """Return the channels with numbers of each group of a .tdms file, by the name of the group."""
    import nptdms

    try:
        with nptdms.TdmsFile.open(io.BytesIO(content)) as file:  # reads no samples yet
            channels = {
                group.name: [each for each in group.channels() if _has_numbers(each)]
                for group in file.groups()
            }
            count = sum(len(each) for of_group in channels.values() for each in of_group)
            if count > MAX_SAMPLES:
                raise InvalidProblem.at(where, f"has more than {MAX_SAMPLES} samples")
            if file.file_status.incomplete_final_segment:  # the samples that are there are read
                text = "ends in the middle of a segment; copy the file again"
                raise InvalidProblem.at(where, text)
            groups = {
                name: [
                    _tdms_channel(each, start)
                    for each, start in zip(of_group, _starts(of_group), strict=True)
                ]
                for name, of_group in channels.items()
            }
    except InvalidProblem:
        raise
    except Exception as fault:  # the reader raises many types for damaged files
        raise InvalidProblem.at(where, f"is not a .tdms file that can be read: {fault}") from None
    return {name: channels for name, channels in groups.items() if channels}


def _has_numbers(channel: Any) -> bool:
    """Return True for a channel of a .tdms file with samples that are numbers."""
    return len(channel) > 0 and channel.dtype.kind in "iuf"


def _tdms_channel(channel: Any, start: float) -> Channel:
    """Return a channel of a .tdms file, scaled by the properties that the file states.

    ``start`` is the instant of its first sample [s].
    """
    properties = channel.properties
    period = float(properties.get("wf_increment", np.nan))
    unit = str(properties.get("unit_string", ""))
    values = np.asarray(channel[:], dtype=float)
    return Channel(channel.name, unit, values, start, period if period > 0 else np.nan)


def _starts(channels: Sequence[Any]) -> Array:
    """Return when the channels of a group of a .tdms file start, (channels,) [s], the first at 0.

    They are nan for a channel of which the file does not state it.  If it states none, the channels
    start together, apart from their offsets.
    """
    if not channels:
        return np.zeros(0)
    instants = np.array(
        [np.datetime64(each.properties.get("wf_start_time", NO_START), "us") for each in channels]
    )
    offsets = [float(each.properties.get("wf_start_offset", 0.0)) for each in channels]
    starts = np.where(instants == NO_START, np.nan, instants.astype(np.int64) * 1e-6)
    if np.isnan(starts).all():
        starts = np.zeros(len(channels))
    starts = starts + offsets
    return np.asarray(starts - np.nanmin(starts))
