from .app import (
    COMMANDS as COMMANDS,
    WELCOME as WELCOME,
    build_app as build_app,
    main as main,
)
from .operator.watching import Watcher as Watcher
from .plan import new_test as new_test
from .shared.series import read_conditions as read_conditions
from .simulate import (
    PublishedRun as PublishedRun,
    published_run as published_run,
)
