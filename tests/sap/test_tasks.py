"""The four tasks: starting, stopping, stepping each other, their status and output (3.2, 4.3.2.10, 6.6)."""

from __future__ import annotations

import pytest

from tests.sap.jobs import Job, findings

COUNT = "begin while true do CI{0} := CI{0} + 1; end."


def with_worker(text: str, worker: str = COUNT.format(2)) -> Job:
    """A program in task 0, another one loaded into task 2."""
    job = Job(text)
    job.load(worker, 2)
    return job


@pytest.mark.shows("task.four-tasks", "task.equal-priority", "sap.tasks.numbers", "sap.tasks.equal-priority")
def test_four_endless_tasks_progress_alike() -> None:
    job = Job(COUNT.format(0))
    for task in (1, 2, 3):
        job.load(COUNT.format(task), task)
        job.mcu.startcnct(task)
    job.mcu.advance(1000)
    counts = [job.ci(n) for n in range(4)]
    assert min(counts) > 5000 and max(counts) - min(counts) <= 20


@pytest.mark.shows("task.common-variables-shared", "sap.mode.sync-variables")
def test_common_variables_are_the_same_for_all() -> None:
    job = with_worker(
        "begin startcnct(2); repeat until CI1 = 7; CI3 := 1; end.", "begin repeat until CI0 = 5; CI1 := 7; end."
    )
    job.mcu.advance(50)
    assert job.ci(3) == 0
    job.mcu.wrci(0, 5)
    job.run()
    assert job.ci(3) == 1


@pytest.mark.shows("task.common-buffer-private", "sap.common.buffer", "sap.wrcb.pc-visible")
def test_each_task_has_its_own_buffer() -> None:
    job = with_worker("begin wrcbi(0, 11); end.", "begin wrcbi(0, 22); CI0 := rdcbi(4); end.")
    job.mcu.wrcbcnct(2, bytes(4) + (77).to_bytes(4, "little"))
    job.mcu.startcnct(2)
    job.run()
    job.mcu.advance(5)
    assert [int.from_bytes(job.mcu.rdcbcnct(n, 4), "little") for n in (0, 2)] == [11, 22]
    assert job.ci(0) == 77


@pytest.mark.shows(
    "sap.startcnct", "sap.tasks.control-each-other", "sap.stopcnct", "sap.stopcnct.continuable", "sap.contcnct"
)
def test_a_task_starts_stops_and_continues_another() -> None:
    job = with_worker(
        "begin startcnct(2); wt(1000); stopcnct(2); CI5 := CI2; wt(1000); CI6 := CI2; contcnct(2); wt(1000); "
        "CI7 := CI2; end."
    )
    job.run()
    assert 0 < job.ci(5) == job.ci(6) < job.ci(7)


@pytest.mark.shows("sap.startcnct.self")
def test_a_task_restarts_itself() -> None:
    job = Job(
        "var n : integer; begin n := n + 1; CI1 := n; CI0 := CI0 + 1; if CI0 < 3 then startcnct(0); "
        "CI2 := CI2 + 1; end."
    ).run()
    assert (job.ci(0), job.ci(1), job.ci(2)) == (3, 1, 1)


@pytest.mark.shows("sap.startcnct.running-task")
def test_starting_a_running_task_begins_anew() -> None:
    job = with_worker(
        "begin startcnct(2); wt(500); startcnct(2); wt(500); end.",
        "begin CI0 := CI0 + 1; while true do CI1 := CI1 + 1; end.",
    )
    job.run()
    assert job.ci(0) == 2


@pytest.mark.shows("sap.contcnct.not-self")
def test_a_stopped_task_cannot_continue_itself() -> None:
    job = Job("begin CI0 := 1; stop; contcnct(0); CI0 := 2; end.").run()
    job.mcu.advance(100)
    assert job.ci(0) == 1


@pytest.mark.shows("sap.stop", "sap.stop.continuable", "pcap.contcnct")
def test_stop_and_continue() -> None:
    job = Job("begin CI0 := 1; stop; CI0 := 2; end.").run()
    assert job.ci(0) == 1 and job.mcu.rdcncts(0).running == 0
    job.mcu.contcnct(0)
    job.run()
    assert job.ci(0) == 2


@pytest.mark.shows("sap.stop.no-events", "sap.stopcnct.no-events", "pcap.stopcnct.events-off")
@pytest.mark.parametrize("how", ["stop", "stopcnct"])
def test_no_events_after_stop(how: str) -> None:
    job = Job(
        f"procedure EVUI; begin CI1 := 1; end; begin enev(EVUI); CI0 := 1; "
        f"{'stop;' if how == 'stop' else 'while CI0 = 1 do ;'} CI0 := 2; wt(50); while CI3 = 0 do ; end."
    )
    job.mcu.advance(5)
    job.mcu.stopcnct(0)
    job.mcu.set_inputs(1 << 7)
    job.mcu.advance(50)
    assert job.ci(1) == 0
    job.mcu.wrci(0, 2)
    job.mcu.contcnct(0)
    job.mcu.advance(50)
    assert job.ci(1) == 0, "enev lasts until the task stops"


@pytest.mark.shows("sap.abort.not-continuable", "pcap.contcnct.not-after-abort")
def test_abort_cannot_be_continued() -> None:
    job = Job("begin CI0 := CI0 + 1; abort; CI1 := 1; end.").run()
    job.mcu.contcnct(0)
    job.mcu.advance(50)
    assert (job.ci(0), job.ci(1)) == (1, 0)
    job.mcu.startcnct(0)
    job.run()
    assert job.ci(0) == 2


@pytest.mark.shows(
    "sap.stepcnct",
    "sap.stepcnct.whole-line",
    "sap.stepcnct.running-2",
    "task.status.running-bit-1",
    "pcap.stepcnct.done",
)
def test_a_step_is_a_line() -> None:
    job = with_worker(
        "begin stepcnct(2); wt(100); CI5 := CI0; stepcnct(2); wt(100); CI6 := CI0; contcnct(2); wt(100); "
        "CI7 := CI0; end.",
        "begin\nCI0 := 1; CI0 := 2;\nCI0 := 3;\nCI0 := 4;\nend.",
    )
    job.mcu.advance(4)
    assert job.mcu.rdcncts(2).running == 2
    job.run()
    assert (job.ci(5), job.ci(6), job.ci(7)) == (2, 3, 4)


@pytest.mark.shows("sap.stepcnct.no-events")
def test_no_events_between_steps() -> None:
    job = Job("procedure EVUI; begin CI1 := 1; end;\nbegin enev(EVUI);\nCI0 := 1;\nCI0 := 2;\nCI0 := 3;\nend.")
    job.mcu.stopcnct(0)
    job.mcu.stepcnct(0)
    job.mcu.advance(5)
    job.mcu.set_inputs(1 << 7)
    for _ in range(2):
        job.mcu.stepcnct(0)
        job.mcu.advance(5)
    assert job.ci(0) > 0 and job.ci(1) == 0


@pytest.mark.shows("sap.stepcnct.needs-program")
def test_stepping_without_a_program_does_nothing() -> None:
    job = Job("begin stepcnct(3); CI0 := 1; end.").run()
    assert job.ci(0) == 1 and job.mcu.rdcncts(3).running == 0


@pytest.mark.shows("sap.stoptoss", "sap.stoptoss.not-stopped")
def test_from_stop_to_single_step() -> None:
    job = with_worker(
        "begin startcnct(2); wt(100); stoptoss(2); wt(100); CI5 := CI2; stopcnct(2); stoptoss(2); CI6 := CI2; "
        "wt(1000); end."
    )
    job.run(0.05)
    job.run(0.005)
    assert job.mcu.rdcncts(2).running == 2
    assert job.ci(5) > 0 and job.ci(2) == job.ci(6)


@pytest.mark.shows("sap.stoptoss.spooled-motion")
def test_spooled_motion_runs() -> None:
    worker = "begin cl(A1); TRAC := 500.0; TRVL := 50.0; smla(A1 := 10.0); while true do ; end."
    job = with_worker("begin startcnct(2); wt(100); stopcnct(2); stoptoss(2); wt(15625); CD0 := A1.dp; end.", worker)
    assert job.run().cd(0) == pytest.approx(10.0)


@pytest.mark.shows(
    "sap.contcnct.range", "sap.startcnct.range", "sap.stepcnct.range", "sap.stopcnct.range", "sap.stoptoss.range"
)
@pytest.mark.parametrize("command", ["contcnct", "startcnct", "stepcnct", "stopcnct", "stoptoss"])
def test_task_numbers_are_constants_from_0_to_3(command: str) -> None:
    lines = ["const w = 2;", "var n : integer;", "begin", f"{command}(w); {command}(3);"]
    lines += [f"{command}({wrong});" for wrong in ("4", "n", "-1", "1.0")]
    text = "\n".join([*lines, "end."])
    assert sorted({d.line for d in findings(text) if not d.is_warning}) == [5, 6, 7, 8]


@pytest.mark.shows(
    "task.status.errnum", "task.status.errline", "runtime-error.task-stops", "runtime-error.number-and-line"
)
def test_a_runtime_error_stops_its_task_only() -> None:
    job = with_worker("var i : integer;\nbegin\nstartcnct(2);\nCI0 := 1 / i;\nCI1 := 1;\nend.")
    job.mcu.advance(20)
    assert (job.mcu.rdcncts(0).errnum, job.mcu.rdcncts(0).errline, job.mcu.rdcncts(0).running) == (0x8000, 4, 0)
    before = job.ci(2)
    job.mcu.advance(20)
    assert job.ci(1) == 0 and job.ci(2) > before and job.mcu.rdcncts(2).errnum == 0


@pytest.mark.shows("task.status.stackfree", "struct.cncts.stackfree")
def test_the_stack_shrinks_in_calls() -> None:
    job = Job(
        "procedure P(n : integer); var a, b, c : double; begin if n > 0 then P(n - 1); wt(100); end; "
        "begin wt(100); P(5); end."
    )
    job.mcu.advance(2)
    before = job.mcu.rdcncts(0).stackfree
    job.mcu.advance(10)
    inside = job.mcu.rdcncts(0).stackfree
    assert 0 < inside < before


@pytest.mark.shows("task.status.running-bit-0", "task.status.running-bit-3", "sap.wt.idle")
def test_running_bits() -> None:
    job = Job("begin cl(A1); wt(2000); jaw(A1 := 10.0); while true do ; end.")
    job.mcu.advance(10)
    assert job.mcu.rdcncts(0).running == 0b1001
    job.mcu.advance(150)
    assert job.mcu.rdcncts(0).running == 0b1001
    job.mcu.advance(2000)
    assert job.mcu.rdcncts(0).running == 0b0001


@pytest.mark.shows("task.status.csrcline")
def test_the_line_being_executed() -> None:
    job = Job("begin\nwt(1000);\nwt(1000);\nend.")
    job.mcu.advance(10)
    first = job.mcu.rdcncts(0).csrcline
    job.mcu.advance(50)
    assert (first, job.mcu.rdcncts(0).csrcline) == (2, 3)


@pytest.mark.shows("task.status.running-bit-2", "modereg.stopatwriteln", "struct.cncts.running-bit2")
def test_stop_at_writeln() -> None:
    job = Job("begin MODEREG := $04000000; writeln('a'); CI0 := 1; end.").run()
    assert job.mcu.rdcncts(0).running & 4 and job.ci(0) == 0
    job.mcu.contcnct(0)
    job.run()
    assert job.ci(0) == 1 and job.mcu.rdcncts(0).running == 0


@pytest.mark.shows(
    "sap.write.tskinfo", "sap.writeln.tskinfo", "sap.writeln.overwrites", "task.tskinfo.bit-0", "task.tskinfo.bit-1"
)
def test_output_string() -> None:
    job = Job("begin write('a'); write('b'); wt(100); writeln('c'); wt(100); write('d'); end.")
    job.mcu.advance(2)
    assert job.mcu.gettskinfo(0) == 1
    job.mcu.advance(8)
    assert job.mcu.gettskinfo(0) == 2
    job.run()
    assert job.mcu.gettskinfo(0) == 1
    assert job.mcu.gettskstr(0) == "d" and job.mcu.gettskinfo(0) == 0


@pytest.mark.shows("task.tskstr.max-512", "pcap.gettskstr.max-512")
def test_an_output_string_has_512_bytes() -> None:
    job = Job("var i : integer; begin for i := 1 to 200 do write('abcde'); end.").run()
    assert len(job.mcu.gettskstr(0)) == 512


@pytest.mark.shows("sap.mode.standalone", "sympas.prog.end-stops-task")
def test_the_end_of_the_program_ends_the_task() -> None:
    job = Job("begin CI0 := 1; end.").run()
    job.mcu.advance(10)
    assert job.ci(0) == 1 and job.mcu.rdcncts(0).running == 0


@pytest.mark.shows("sysparam.IRQPC.pc-side", "pcap.rdirqpc.sap")
def test_the_interrupt_reaches_the_pc() -> None:
    job = Job("begin wt(100); IRQPC := true; wt(1000); CI0 := 1; end.")
    seen: list[int] = []
    job.mcu.mcug3_setboardintroutine(lambda *_: seen.append(job.mcu.rdirqpc()))
    job.run()
    assert seen == [1]


@pytest.mark.shows("sap.rs.keeps-data", "sap.rs.outputs-default", "sap.rs.overrides", "sap.rs.software-limits")
def test_rs_in_a_program() -> None:
    job = Job(
        "begin cl(A1); shp(A1 := 0.0); A1.digob.6 := false; A1.digob.2 := true; TROVR := 0.5; utrovr(A1); "
        "A1.jvl := 33.0; CI5 := 5; A1.slr := 5.0; wt(100); rs; end."
    ).run()
    job.mcu.advance(2)
    assert (job.mcu.rddigob("A1", 6), job.mcu.rddigob("A1", 2)) == (1, 0)
    assert job.mcu.rdtrovr() == 1.0 and job.mcu.rdjovr("A1") == 1.0
    assert job.mcu.rdjvl("A1") == 33.0 and job.ci(5) == 5
    job.mcu.cl(["A1"])
    job.mcu.ja({"A1": 10.0})
    job.mcu.advance(2000)
    assert job.mcu.rddp("A1") == pytest.approx(10.0)


@pytest.mark.shows("sap.azo.off")
def test_the_pc_switches_zero_offsets_off() -> None:
    job = Job("begin azo(1); end.").run()
    assert job.mcu.rdzerooffset("A1") == 20.0
    job.mcu.azo(5)
    assert job.mcu.rdzerooffset("A1") == 0.0


@pytest.mark.shows("sap.lpr", "sap.lprs", "sysparam.LET.1000-samples", "sysparam.LET.rounding")
def test_recordings_of_a_program() -> None:
    job = Job(
        "begin cl(A1, A2); LST := 0.128; LET := 1.0; ja(A1 := 50.0); lpr(A1); wt(35000); LET := 2.0; lprs(A1, A2); end."
    )
    job.mcu.advance(1500)
    found = job.mcu.analysis("A1")
    assert len(found["dp"]) == 1000 and not job.mcu.analysis("A2")["dp"]
    assert found["t_s"][-1] - found["t_s"][0] == pytest.approx(999 * 0.00128)
    assert found["t_s"][0] == pytest.approx(0.128, abs=0.01)
    assert max(found["dp"]) == pytest.approx(50.0)
    job.run()
    job.mcu.advance(2200)
    both = [job.mcu.analysis(axis) for axis in ("A1", "A2")]
    assert [len(f["dp"]) for f in both] == [1000, 1000] and both[0]["t_s"] == both[1]["t_s"]
    assert both[0]["t_s"][-1] - both[0]["t_s"][0] == pytest.approx(2 * 999 * 0.00128)


@pytest.mark.shows("pcap.ctru.sap", "appvar.sys.sap", "appvar.axis.sap")
def test_registers_are_those_of_the_pc() -> None:
    job = Job(
        "begin CI0 := PU; CI1 := TU; CI2 := SysVarInt[3]; CD0 := A1.vardbl[2]; SysVarDbl[1] := 2.5; PU := 2; end."
    )
    job.mcu.ctru("inch", "min")
    job.mcu.wrsysvarint(3, 33)
    job.mcu.wraxvardbl("A1", 2, 1.25)
    job.run()
    assert (job.ci(0), job.ci(1), job.ci(2), job.cd(0)) == (1, 1, 33, 1.25)
    assert job.mcu.rdsysvardbl(1) == 2.5


@pytest.mark.shows("qual.epc")
def test_a_program_reads_the_cycles_of_the_eeprom() -> None:
    job = Job("begin CI0 := A1.epc; wt(1000); CI1 := A2.epc; end.")
    job.mcu.advance(2)
    job.mcu.program_eeprom()
    job.run()
    assert (job.ci(0), job.ci(1)) == (0, 1)
