//! How long the run was at each stage of its workflow.

/// How long the run was at each stage.
#[derive(Debug, Default)]
pub(super) struct StageTimes {
    first_ns: Option<i64>,
    at_ns: i64,
    stage: String,
    totals_ns: Vec<(String, u64)>,
}

impl StageTimes {
    /// From here on the run is at this stage.
    pub(super) fn begins(&mut self, t_ns: i64, stage: &str) {
        self.pass(t_ns);
        if self.first_ns.is_none() {
            (self.first_ns, self.at_ns) = (Some(t_ns), t_ns);
        }
        stage.clone_into(&mut self.stage);
    }

    /// What is said late counts from then on: time does not go back.
    fn pass(&mut self, t_ns: i64) {
        if self.first_ns.is_some() && t_ns > self.at_ns {
            let ns = (t_ns - self.at_ns).unsigned_abs();
            self.at_ns = t_ns;
            match self.totals_ns.iter_mut().find(|(stage, _)| *stage == self.stage) {
                Some((_, total)) => *total += ns,
                None => self.totals_ns.push((self.stage.clone(), ns)),
            }
        }
    }

    /// The time of each stage in a recording from `from_ns` to `to_ns`, in the order in which they were reached.
    pub(super) fn finish(&mut self, from_ns: i64, to_ns: i64) -> Vec<(String, u64)> {
        self.pass(to_ns);
        let first_ns = self.first_ns.unwrap_or(to_ns);
        let before = ("not told".to_owned(), first_ns.saturating_sub(from_ns).unsigned_abs());
        let told = std::mem::take(&mut self.totals_ns);
        [before].into_iter().chain(told).filter(|(_, ns)| *ns > 0).collect()
    }
}
