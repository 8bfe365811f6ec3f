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
