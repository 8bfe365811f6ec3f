"""`ports`: which ports are there, what they speak, which indicators are known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.base.errors import UsageError
from scara_iso.commands.output import write_json, write_report

if TYPE_CHECKING:
    from scara_iso.reporting import Probe

SECONDS = 3.0
_QUIET_S = 0.2


def ports_command(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="With --dialects: only those of this maker or key: mahr.",
            show_default=False,
        ),
    ] = None,
    *,
    dialects: Annotated[
        bool, typer.Option("--dialects", help="The indicators known, and what is unverified.")
    ] = False,
    probe: Annotated[
        str | None, typer.Option(metavar="PORT", help="Listen to a port for 3 s.")
    ] = None,
    ask: Annotated[
        str | None,
        typer.Option(
            metavar="DRIVER", help="With --probe: its settings, and its request once a second."
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="One JSON object.")] = False,
) -> None:
    """List serial ports, the dialects of indicators, or what comes out of one port.

    Example: scara-iso ports --probe /dev/ttyUSB0 --ask opto-rs232
    """
    if name is not None and not dialects:
        raise UsageError(f"{name}: only --dialects takes a name", remedy=f"ports --dialects {name}")
    if ask is not None and probe is None:
        raise UsageError("--ask needs a port", remedy="give --probe PORT too")
    if probe is not None:
        _probe(probe, ask, json=json)
    elif dialects:
        _dialects(name or "", json=json)
    else:
        _list(json=json)


def _list(*, json: bool) -> None:
    from scara_iso.base.published import to_json
    from scara_iso.recorder import list_devices
    from scara_iso.reporting import PublishedPorts, ports_report

    devices = list_devices()
    if json:
        write_json(to_json(PublishedPorts(schema="scara-iso/ports/1", ports=devices)))
    else:
        write_report(ports_report((d.name, str(d), d.description) for d in devices))


def _dialects(name: str, *, json: bool) -> None:
    from scara_iso.base.published import to_json
    from scara_iso.recorder import find_dialects
    from scara_iso.reporting import dialects_report, published_dialects

    found = {
        key: dialect
        for key, dialect in find_dialects().items()
        if name.casefold() in f"{key} {dialect.instruments}".casefold()
    }
    if not found:
        raise UsageError(f"no dialect is called {name!r}", remedy="scara-iso ports --dialects")
    if json:
        write_json(to_json(published_dialects(found)))
    else:
        write_report(dialects_report(found.values()))


def _probe(address: str, key: str | None, *, json: bool) -> None:
    from scara_iso.base.published import to_json
    from scara_iso.reporting import probe_report, published_probe

    probe = _listen(address, key)
    if json:
        write_json(to_json(published_probe(probe)))
    else:
        write_report(probe_report(probe))


def _listen(address: str, key: str | None) -> Probe:
    from scara_iso.recorder import Decoder, choose_clock, find_dialect, find_dialects, open_port
    from scara_iso.reporting import Probe

    dialect = find_dialect(key or "mitutoyo-mux")  # its 9600 8N1 where no other line is named
    clock = choose_clock([address])
    port = open_port(address, dialect, axis="X", clock=clock, asked=key is not None)
    received, asked_at = b"", _QUIET_S - 1.0
    try:
        while clock.now() < SECONDS:
            received += port.read()
            if key is not None and clock.now() >= asked_at + 1.0:
                asked_at = clock.now()
                if dialect.request is not None:
                    port.write(dialect.request)
                elif dialect.request_line is not None:
                    port.pulse(dialect.request_line)
            clock.idle(min(SECONDS, asked_at + 1.0) if key else SECONDS)
    finally:
        port.close()
    events = {k: tuple(Decoder(d).feed(received)) for k, d in find_dialects().items()}
    return Probe(address, SECONDS, str(dialect.line), received, events)
