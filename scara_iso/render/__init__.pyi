from .formats import endings as endings, find_format as find_format
from .live import (
    AxisView as AxisView,
    LiveScreen as LiveScreen,
    LiveView as LiveView,
    track as track,
)
from .pictures import plot as plot
from .plots import (
    check_map as check_map,
    check_picture as check_picture,
    plot_plan as plot_plan,
    plot_separating as plot_separating,
    save_figure as save_figure,
    save_map as save_map,
)
from .terminal import open_console as open_console, show as show
