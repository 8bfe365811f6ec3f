"""A hundred tests at once: how their RP varies, and what is in the worst of them."""

from pathlib import Path

import pandas as pd

import scara_iso

folder = Path("study")
folder.mkdir(exist_ok=True)
for k in range(100):  # in place of your own files
    effects = ["step:at_cycle=15,size=0.03"] if k % 25 == 24 else []
    run = scara_iso.simulate("examples/fum_scara.toml", effects=effects, seed=k)
    (folder / f"test_{k:03}.csv").write_text(scara_iso.write_table(run), encoding="utf-8")

poses = {path.name: scara_iso.analyze(path).poses[0] for path in sorted(folder.glob("*.csv"))}
table = pd.DataFrame({"XY": {name: pose.XY.RP for name, pose in poses.items()}})
table["upper"] = [pose.XY.RP_interval[1] for pose in poses.values()]
print(table.describe().loc[["count", "mean", "min", "max"]].round(4))
for name in table.nlargest(5, "XY").index:
    print(name, scara_iso.diagnose(folder / name))
