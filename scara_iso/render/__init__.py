"""How a result looks: terminal, HTML, JSON, plots. What is said of it is decided elsewhere."""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.render.comparison_plot import plot_comparison as plot_comparison
    from scara_iso.render.formats import endings as endings, find_format as find_format
    from scara_iso.render.formats.json import report_json as report_json
    from scara_iso.render.json import (
        analysis_json as analysis_json,
        explain_json as explain_json,
        plan_json as plan_json,
        run_json as run_json,
        to_text as to_text,
    )
    from scara_iso.render.json_backlash import backlash_json as backlash_json
    from scara_iso.render.json_comparison import comparison_json as comparison_json
    from scara_iso.render.json_diagnosis import (
        design_json as design_json,
        diagnosis_json as diagnosis_json,
    )
    from scara_iso.render.json_whole_test import (
        conditions_json as conditions_json,
        status_json as status_json,
    )
    from scara_iso.render.live import (
        AxisView as AxisView,
        LiveScreen as LiveScreen,
        LiveView as LiveView,
    )
    from scara_iso.render.plots import plot_diagnosis as plot_diagnosis, plot_plan as plot_plan
    from scara_iso.render.progress import track as track
    from scara_iso.render.terminal import open_console as open_console, show as show
else:
    __getattr__ = face(__name__)
