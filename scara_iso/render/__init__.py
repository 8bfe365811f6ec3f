"""How a result looks: terminal, HTML, JSON, plots. What is said of it is decided elsewhere."""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.base.published import to_text as to_text
    from scara_iso.render.formats import endings as endings, find_format as find_format
    from scara_iso.render.live import (
        AxisView as AxisView,
        LiveScreen as LiveScreen,
        LiveView as LiveView,
        track as track,
    )
    from scara_iso.render.pictures import plot as plot
    from scara_iso.render.plots import (
        check_map as check_map,
        check_picture as check_picture,
        plot_plan as plot_plan,
        plot_separating as plot_separating,
        save_figure as save_figure,
        save_map as save_map,
    )
    from scara_iso.render.terminal import open_console as open_console, show as show
else:
    __getattr__ = face(__name__)
