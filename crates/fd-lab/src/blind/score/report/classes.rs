//! The table of a class of logs as people have them.

use fd_model::figure;
use fd_report::Table;

use crate::blind::score::{ClassScore, Rate};

impl ClassScore {
    /// All that was counted; what does not apply to the class is left out.
    pub(super) fn table(&self) -> Table {
        let mut table = Table::new(&self.title, &["measure", "result", "target"]);
        let mut row = |what: &str, rate: &Rate, target: &str| {
            if 0 < rate.of {
                table.push([what.to_owned(), rate.text(), target.to_owned()]);
            }
        };
        let is_looped = ["loop", "unstable"].contains(&self.name.as_str());
        let (right, sure) = if is_looped { (".85", ".97") } else { ("", "") };
        row("what is wrong can be seen", &self.visible, "");
        row("right cause first (or inseparable)", &self.right, right);
        row("  very label and site", &self.exact, "");
        row("  mechanism and place", &self.place, if self.name == "inside" { ".75" } else { "" });
        row("one cause named: it is right", &self.alone, ".99");
        row("stated p > .9 is right", &self.sure, sure);
        row("falsely \"none of these\"", &self.falsely_none, "");
        row("unknown class told by the diagnosis itself", &self.told[0], "");
        row("unknown class told at 3 % false doubt", &self.told[1], ".80");
        row("largest of four named first", &self.list[0], ".90");
        row("list exact or inseparable", &self.list[1], ".50");
        row("  where each is worth 25 squares of the noise beside the others", &self.list[2], "");
        row("  effects worth that much that are named", &self.of_several[0], "");
        row("  named causes that are among the effects", &self.of_several[1], "");
        row("mistake of reading told as such", &self.reading[0], ".90");
        row("mistake of reading taken for physics at p > .5", &self.reading[1], ".02");
        let blamed = if is_looped { ".04" } else { ".02" };
        row("no gap, blamed with p > .5: white noise", &self.blamed[0], blamed);
        row("no gap, blamed with p > .5: AR(.8) noise", &self.blamed[1], blamed);
        row("95 % interval of the closed share covers", &self.coverage, ".95");
        if let Some(other) = &self.comparison {
            let form = &other.form;
            row("the same cases as logged: right cause first", &other.right[0], "");
            row(&format!("the same with {form}: right cause first"), &other.right[1], "");
            row(&format!("the same with {form}: stated p > .9 is right"), &other.sure, "");
            row(&format!("the same with {form}: no gap blamed"), &other.blamed, "");
        }
        row("wide refit of parameters: right", &self.baselines[0], "");
        row("sparse regression: right", &self.baselines[1], "");
        if !self.group.bins.is_empty() {
            let target = if is_looped { ".06" } else { "" };
            let error = format!("{:.3}", self.group.error);
            table.push(["calibration error of groups", error.as_str(), target]);
        }
        let times = format!("{} ({})", figure(self.seconds[0]), figure(self.seconds[1]));
        table.push(["seconds per diagnosis, median (90 % quantile)", times.as_str(), ""]);
        if 0 < self.failed.hits {
            table.push(["diagnoses that failed", self.failed.text().as_str(), ""]);
        }
        table
    }
}
