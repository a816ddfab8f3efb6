//! Which sightings take part.

use geometry::motion::Pose;
use nalgebra::Vector3;

use super::adjust::{Problem, Settled};
use super::schur::State;
use super::views::{Data, Station, width_mm};
use super::vote::Vote;
use super::{Options, Refused};

/// Rounds of adjusting and leaving out.
const MAX_ROUNDS: usize = 20;
/// The median of chi-square with three degrees of freedom (Abramowitz and Stegun 1964, table 26.8).
const MEDIAN_CHI_SQUARE: f64 = 2.365_973_884;

/// A mark per sighting: whether it takes part.
pub(super) struct Choice<'a> {
    data: &'a Data,
    vote: &'a Vote,
    options: &'a Options,
    kept: Vec<Vec<bool>>,
}

/// The adjustment of what was kept.
pub(super) struct Adjusted {
    pub(super) problem: Problem,
    pub(super) settled: Settled,
    /// The station of `data` behind each of the problem's.
    pub(super) origin: Vec<usize>,
    pub(super) kept: Vec<Vec<bool>>,
    /// The emitter of each column.
    pub(super) names: Vec<usize>,
}

impl<'a> Choice<'a> {
    /// All that agrees with the vote.
    pub(super) fn new(data: &'a Data, vote: &'a Vote, options: &'a Options) -> Self {
        let all = data.stations.iter().zip(&vote.laid);
        let kept = all.map(|(station, laid)| {
            laid.as_ref()
                .map_or_else(|| vec![false; station.sightings.len()], |l| l.fits.clone())
        });
        Self {
            data,
            vote,
            options,
            kept: kept.collect(),
        }
    }

    /// Adjusts, leaves out what lies beyond the gate, the worst of each view first, and adjusts again until nothing
    /// does.
    pub(super) fn adjust(mut self) -> Result<Adjusted, Refused> {
        let mut last_mm = f64::INFINITY;
        for _ in 0..MAX_ROUNDS {
            let (problem, origin, names) = self.problem()?;
            let settled = problem.settle(self.start(&problem, &origin, &names))?;
            let squares = problem.squares(&settled.state);
            let worst = self.leave_out(&problem, &origin, &squares);
            if worst == 0.0 {
                return Ok(Adjusted {
                    problem,
                    settled,
                    origin,
                    kept: self.kept,
                    names,
                });
            }
            last_mm = worst.sqrt() * self.data.sigma_mm;
        }
        Err(Refused::NoConvergence {
            steps: MAX_ROUNDS,
            last_mm,
        })
    }

    /// Marks the worst sighting of each view beyond the gate; the largest square of these, or 0.
    fn leave_out(&mut self, problem: &Problem, origin: &[usize], squares: &[Vec<f64>]) -> f64 {
        let mut all: Vec<f64> = squares.iter().flatten().copied().collect();
        all.sort_unstable_by(f64::total_cmp);
        // Where the noise given is too small, the gate opens with the residuals' own median.
        // Never below 1: residuals better than the noise given are no reason to leave out more.
        let scale = all.get(all.len() / 2).map_or(1.0, |m| (m / MEDIAN_CHI_SQUARE).max(1.0));
        let limit = self.options.gate * self.options.gate * scale;
        let mut largest = 0.0_f64;
        for ((station, list), origin) in problem.stations.iter().zip(squares).zip(origin) {
            // One of each view at a time: a gross error pulls the pose of its view, and good sightings look wrong with
            // it.
            let Some(worst) = (0..list.len()).max_by(|a, b| list[*a].total_cmp(&list[*b])) else {
                continue;
            };
            if list[worst] > limit {
                let emitter = station.sightings[worst].emitter;
                let sightings = &self.data.stations[*origin].sightings;
                if let Some(i) = sightings.iter().position(|s| s.emitter == emitter) {
                    self.kept[*origin][i] = false;
                    largest = largest.max(list[worst]);
                }
            }
        }
        largest
    }

    /// The sightings kept in station `i`, where they give a pose.
    fn station(&self, i: usize) -> Option<Station> {
        let full = &self.data.stations[i];
        let kept = full.sightings.iter().zip(&self.kept[i]).filter(|(_, k)| **k);
        let sightings: Vec<_> = kept.map(|(s, _)| s.clone()).collect();
        let places: Vec<_> = sightings.iter().map(|s| s.place).collect();
        (width_mm(&places) >= self.data.least_width_mm()).then(|| Station {
            sightings,
            ..full.clone()
        })
    }

    /// The problem of what is kept; emitters seen too seldom are refused or left out.
    fn problem(&mut self) -> Result<(Problem, Vec<usize>, Vec<usize>), Refused> {
        // Leaving out an emitter may leave a station with too few, and that another emitter with too few stations.
        loop {
            let origin: Vec<usize> = (0..self.kept.len()).filter(|i| self.station(*i).is_some()).collect();
            let stations: Vec<Station> = origin.iter().filter_map(|i| self.station(*i)).collect();
            let counts = counted(&stations, self.data.emitters);
            // With 0 an emitter that nobody saw would pass as one that is known.
            let needed = self.options.needed_views.max(1);
            if !self.options.allow_missing {
                enough(&counts, needed)?;
            }
            let seldom = |emitter: usize| counts[emitter] > 0 && counts[emitter] < needed;
            if !(0..counts.len()).any(seldom) {
                let names: Vec<usize> = (0..counts.len()).filter(|e| counts[*e] > 0).collect();
                // Two emitters leave the turn about their line free in every view.
                self.some(&names)?;
                let mut columns = vec![None; counts.len()];
                names.iter().enumerate().for_each(|(c, e)| columns[*e] = Some(c));
                let problem = Problem {
                    stations,
                    columns,
                    radius: self.radius(&names),
                };
                return Ok((problem, origin, names));
            }
            for (station, kept) in self.data.stations.iter().zip(&mut self.kept) {
                let marks = station.sightings.iter().zip(kept);
                marks.for_each(|(s, k)| *k &= !seldom(s.emitter));
            }
        }
    }

    fn some(&self, names: &[usize]) -> Result<(), Refused> {
        if names.len() >= 3 {
            return Ok(());
        }
        Err(Refused::Collinear {
            views: self.data.stations.len(),
            widest_mm: 0.0,
            needed_mm: self.data.least_width_mm(),
        })
    }

    /// The voted places by column, about their mean.
    fn places(&self, names: &[usize]) -> (Vec<Vector3<f64>>, Vector3<f64>) {
        let places: Vec<Vector3<f64>> = names.iter().filter_map(|e| self.vote.places[*e]).collect();
        let mean = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
        (places.iter().map(|p| p - mean).collect(), mean)
    }

    fn radius(&self, names: &[usize]) -> f64 {
        let (places, _) = self.places(names);
        (places.iter().map(Vector3::norm_squared).sum::<f64>() / places.len() as f64).sqrt()
    }

    fn start(&self, problem: &Problem, origin: &[usize], names: &[usize]) -> State {
        let (places, mean) = self.places(names);
        let pose = |i: &usize| {
            let body = self.vote.laid[*i].as_ref()?.by.inverse();
            // The mean was taken off the places: R b + t = R (b - mean) + (R mean + t).
            let turned = Vector3::from(body.rotation().apply(mean.into()));
            Some(Pose {
                turn: body.rotation(),
                shift: Vector3::from(body.translation_mm()) + turned,
            })
        };
        // None is dropped: a station that was not laid has no sighting kept, and so is not among the problem's.
        let poses: Vec<Pose> = origin.iter().filter_map(pose).collect();
        debug_assert_eq!(poses.len(), problem.stations.len());
        State { places, poses }
    }
}

/// In how many stations each emitter is seen.
pub(super) fn counted(stations: &[Station], emitters: usize) -> Vec<usize> {
    let mut counts = vec![0; emitters];
    let all = stations.iter().flat_map(|s| &s.sightings);
    all.for_each(|s| counts[s.emitter] += 1);
    counts
}

/// Refuses emitters seen in fewer than `needed` stations.
pub(super) fn enough(counts: &[usize], needed: usize) -> Result<(), Refused> {
    let seldom = counts.iter().copied().enumerate().filter(|(_, n)| *n < needed);
    let emitters: Vec<(usize, usize)> = seldom.collect();
    if emitters.is_empty() {
        return Ok(());
    }
    Err(Refused::Seldom { emitters, needed })
}
