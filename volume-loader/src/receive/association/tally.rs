//! What came of an association, series by series.

use std::collections::{BTreeMap, BTreeSet};

use super::super::instance::Ids;
use super::super::outcome::{Came, Ended, Outcome};
use super::super::store::{Placed, Store};
use super::super::uid::Uid;

/// Counts of an association, and its series.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Verifications that were answered.
    pub(super) echoes: u64,
    /// Instances that the peer began to send.
    pub(super) instances: u64,
    /// Those that were refused, or that broke off.
    pub(super) refused: u64,
    series: BTreeMap<[Uid; 2], Series>,
}

/// What is known of a series.
#[derive(Debug)]
struct Series {
    came: Came,
    /// It was incomplete when this association began to send of it.
    was_hidden: bool,
    /// Instances that this association sent and that are kept.
    kept: BTreeSet<Uid>,
}

impl Tally {
    /// An instance whose series is known was kept, or refused (`None`). `was_hidden`: its series lay among the incomplete ones before.
    pub(super) fn arrived(&mut self, ids: Ids, was_hidden: bool, is_slices: bool, placed: Option<Placed>) {
        let series = self.series_of([ids.study, ids.series], was_hidden);
        series.came.is_slices |= is_slices;
        match placed {
            Some(Placed::New) => series.came.stored += 1,
            Some(Placed::Same) => series.came.same += 1,
            None => series.came.refused += 1,
        }
        if placed.is_some() {
            series.kept.insert(ids.instance);
        }
    }

    fn series_of(&mut self, name: [Uid; 2], was_hidden: bool) -> &mut Series {
        self.series.entry(name.clone()).or_insert_with(|| Series {
            came: Came {
                name,
                path: Default::default(),
                is_slices: false,
                stored: 0,
                same: 0,
                refused: 0,
                is_hidden: false,
                lacking: None,
            },
            was_hidden,
            kept: BTreeSet::new(),
        })
    }

    /// Gives the series their names where nothing speaks against it, and tells what came; `bytes` are those of all data sets.
    pub(super) fn outcome(self, ended: Ended, bytes: u64, store: &Store) -> Outcome {
        let series = self.series;
        let known: u64 = series.values().map(|series| series.came.refused).sum();
        let unknown = self.refused.saturating_sub(known);
        let mut all = Vec::new();
        for Series {
            mut came,
            was_hidden,
            kept,
        } in series.into_values()
        {
            let [study, of] = came.name.clone();
            let against = match (&ended, unknown, came.refused) {
                (Ended::Released, 0, 0) => None,
                (Ended::Released, 0, refused) => Some(format!("{refused} of its instances were refused")),
                (Ended::Released, unknown, _) => Some(format!(
                    "{unknown} instances were refused before it was known of which series they are"
                )),
                (ended, _, _) => Some(format!("the association was {ended}")),
            };
            // What an earlier association left incomplete is complete once one association has brought all of it.
            let needed = was_hidden.then_some(&kept);
            let complete = || {
                store
                    .complete([&study, &of], needed)
                    .err()
                    .map(|error| error.to_string())
            };
            came.lacking = against.or_else(complete);
            (came.path, came.is_hidden) = store.path([&study, &of]);
            all.push(came);
        }
        Outcome {
            ended,
            echoes: self.echoes,
            asked: self.instances,
            refused: self.refused,
            bytes,
            series: all,
        }
    }
}
