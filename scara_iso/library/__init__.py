"""One public function for each command: a path, a `Run` or a pandas table in, a result out.

The functions are those of `scara_iso` itself; the command line parses options, calls one of them
and shows what it returns.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.library.beside import read_beside as read_beside
    from scara_iso.library.conditions import (
        ConditionRun as ConditionRun,
        read_conditions as read_conditions,
    )
    from scara_iso.library.diagnoses import Diagnoses as Diagnoses
    from scara_iso.library.figures import analyze as analyze, analyze_many as analyze_many
    from scara_iso.library.fleet_runs import fleet as fleet, fleet_figures as fleet_figures
    from scara_iso.library.folders import (
        new_test as new_test,
        refuse_existing_test as refuse_existing_test,
        write_planned_test as write_planned_test,
    )
    from scara_iso.library.gauge_studies import gauge_study as gauge_study
    from scara_iso.library.inputs import (
        EVENTS as EVENTS,
        Table as Table,
        TableOptions as TableOptions,
        Tables as Tables,
        folders_seen as folders_seen,
        tables_in as tables_in,
    )
    from scara_iso.library.joined import join_reports as join_reports
    from scara_iso.library.loop import (
        diagnose as diagnose,
        diagnose_each as diagnose_each,
        diagnose_many as diagnose_many,
        held_out_pose as held_out_pose,
        one_test as one_test,
    )
    from scara_iso.library.model_files import defined as defined
    from scara_iso.library.models import (
        plan as plan,
        plan_separating as plan_separating,
        simulate as simulate,
    )
    from scara_iso.library.months import history as history
    from scara_iso.library.pages import check_page as check_page, write_page as write_page
    from scara_iso.library.pushes import push as push
    from scara_iso.library.recordings import Nobody as Nobody, record as record
    from scara_iso.library.reports import (
        TestReport as TestReport,
        check_format as check_format,
        report as report,
    )
    from scara_iso.library.selftests import selftest as selftest
    from scara_iso.library.several import compare as compare
    from scara_iso.library.simulated import (
        PublishedRun as PublishedRun,
        published_run as published_run,
    )
    from scara_iso.library.streams import visits as visits
    from scara_iso.library.watching import Watcher as Watcher
else:
    __getattr__ = face(__name__)
