"""What is remembered of a bench: written anew as often as it changes, its instruments kept."""

from scara_iso.recorder import RememberedBench, read_bench, write_bench

INSTRUMENTS = "\n[instrument.X]\nserial_number = '4711'\n\n[instrument.Y]\n# lent\nmaker = 'M'\n"


def test_a_bench_is_written_anew_and_its_instruments_stay(tmp_path):
    path, first = tmp_path / "bench.toml", RememberedBench(("X=opto-rs232@sim:",), "timer:10")
    write_bench(path, first)
    head = path.read_text(encoding="utf-8")
    path.write_text(head + INSTRUMENTS, encoding="utf-8")
    other = RememberedBench(("X=opto-rs232@sim:", "Y=mitutoyo-idh@sim:"), None)
    for bench in (other, first, first):
        write_bench(path, bench)
        assert read_bench(path) == bench
        assert path.read_text(encoding="utf-8").count(INSTRUMENTS) == 1
    assert path.read_text(encoding="utf-8") == head + INSTRUMENTS


def test_nothing_else_in_a_bench_is_changed_when_it_is_written(tmp_path):
    path = tmp_path / "bench.toml"
    text = (
        "# Bench 2, hall 3\n"
        "instrument.Y.name = 'lent'\n\n"
        "[gauges]  # from the left\n"
        'X = "opto-rs232@sim:"  # the new one\n\n'
        "[instrument.X]\ncorrection = [\n  [0, 0],\n  [1, 0.001],\n]\ncertificate = 'K-1'\n"
    )
    path.write_text(text, encoding="utf-8")
    write_bench(path, RememberedBench(("X=mitutoyo-idh@sim:",)))
    assert path.read_text(encoding="utf-8") == text.replace("opto-rs232", "mitutoyo-idh")
