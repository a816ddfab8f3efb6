//! Whether a registration may be used: limits, and what falls short of them, with numbers.
//!
//! A wrong minimum looks confident: its predicted error is as small as that of the right one. What tells it are the points that do not
//! fit (noise ratio, share kept), other minima that fit as well (margin), and how often the search came back to it (hits). Each of them
//! alone lets some through; `docs/surface-registration.md` has the counts.

use std::fmt;

use geometry::{Frame, Point};

use crate::free::{Free, free};
use crate::register::{Class, GrossError, ONE_IN_1000, PointResult, SecondSurface, SurfaceRegistration, Trend};
use crate::search::LEAST_HITS;
use crate::solve::MOST_BEYOND;
use crate::tail::{Tail, tail};

/// What a registration must keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Residuals over the noise that was told, at most; where there are few points so many of its own deviations above 1 are allowed, as
    /// [`Limits::noise_sigmas`] says, if that is more.
    pub most_noise_ratio: f64,
    /// And at least: below, the noise that was told is so large that no wrong pose would be noticed.
    pub least_noise_ratio: f64,
    /// How many deviations of the noise ratio itself it may be off 1.
    pub noise_sigmas: f64,
    /// Cost of the nearest other minimum over that of the result, squares of deviations, at least.
    pub least_margin: f64,
    /// Share, of the points of which the surface says something, that fit, at least.
    pub least_share: f64,
    /// Points that fit, at least.
    pub least_kept: f64,
    /// Share, of the points of which the surface says something, whose beam comes from inside the bone, at most: of a right pose only echoes
    /// face away.
    pub most_facing_away: f64,
    /// Share of the points beyond an open border, at most.
    pub most_beyond: f64,
    /// Root mean square target registration error predicted at each target, mm, at most; and, where points were left out as gross errors, the
    /// most that one more of them would put a target off to first order ([`SurfaceRegistration::gross_error`]).
    pub most_tre_mm: f64,
    /// Fits of the search that led to the result, at least: what was found once only stands for places that were not found at all.
    pub least_hits: usize,
    /// Mean square of the landmarks' misses over what their errors say, at most.
    pub most_landmark_ratio: f64,
    /// How much likelier it is that the last points fit less often than the others, logarithm, at most ([`crate::Tail::likelihood`]).
    pub most_tail: f64,
    /// Depth scale and offset over what was told of them before, deviations, at most.
    pub most_prior: f64,
    /// Square of the difference of the sweep's two parts as two poses in its covariance, at most ([`crate::Halves::square`]).
    pub most_moved: f64,
    /// How unlikely by chance alone it may be that residuals go with the order of the points, or with their side, as deviations of a normal
    /// number, at most ([`Trend::deviations`]): 3.09 is 1 in 1000.
    pub most_trend: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            most_noise_ratio: 1.2,
            least_noise_ratio: 0.6,
            noise_sigmas: 2.5,
            least_margin: 15.0,
            least_share: 0.5,
            least_kept: 15.0,
            most_facing_away: 0.15,
            most_beyond: MOST_BEYOND,
            most_tre_mm: 2.0,
            least_hits: LEAST_HITS,
            most_landmark_ratio: 5.0,
            most_tail: 10.0,
            most_prior: 3.0,
            most_moved: 30.0,
            most_trend: ONE_IN_1000,
        }
    }
}

/// Why a registration must not be used.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// Nothing was searched, so that nothing is known of other minima.
    NotSearched,
    /// The last fit did not settle.
    NotSettled,
    /// Residuals are larger than the noise that was told: a wrong minimum, another bone, or a noise that was told too small.
    Noise {
        /// Residuals over the noise.
        found: f64,
        /// At most allowed.
        most: f64,
    },
    /// Residuals are much smaller than the noise that was told: nothing wrong would be noticed.
    Quiet {
        /// Residuals over the noise.
        found: f64,
        /// At least needed.
        least: f64,
    },
    /// Another pose fits nearly as well.
    Margin {
        /// By how much its cost is higher.
        found: f64,
        /// At least needed.
        least: f64,
        /// How far it lies from the result, mm at the points.
        apart_mm: f64,
    },
    /// Too few of the points fit.
    Share {
        /// Their share.
        found: f64,
        /// At least needed.
        least: f64,
    },
    /// Too few points fit.
    Kept {
        /// How many do.
        found: f64,
        /// At least needed.
        least: f64,
    },
    /// Too many beams come from inside the bone: they are turned round, or sides are.
    FacingAway {
        /// Share of the points.
        found: f64,
        /// At most allowed.
        most: f64,
    },
    /// Too many points lie beyond an open border of the surface: the CT did not go as far.
    Beyond {
        /// Share of the points.
        found: f64,
        /// At most allowed.
        most: f64,
    },
    /// The error predicted at a target is too large.
    Tre {
        /// The target, by its place in the list.
        target: usize,
        /// The error, mm; not a number where there was no target.
        found_mm: f64,
        /// At most allowed, mm.
        most_mm: f64,
    },
    /// There are gross errors among the points, and one more puts a target too far off: too few points, or one that alone holds a motion.
    GrossError {
        /// The point, its error and what it does.
        found: GrossError,
        /// At most allowed at a target, mm.
        most_mm: f64,
        /// How many points were left out.
        left_out: usize,
    },
    /// A motion that the points do not hold.
    Free(Free),
    /// The search came here too seldom to have seen everything.
    Hits {
        /// How often.
        found: usize,
        /// At least needed.
        least: usize,
        /// Of how many fits.
        fits: usize,
    },
    /// The landmarks do not lie where the surface says.
    Landmarks {
        /// Mean square of their misses over what their errors say.
        found: f64,
        /// At most allowed.
        most: f64,
    },
    /// The pose goes with the order of the points: the bone slid slowly against the tracker's reference.
    Drifted {
        /// How.
        found: Trend,
        /// At most allowed, deviations.
        most: f64,
    },
    /// Points on one side lie further outside of the bone than those on the other one: soft tissue under the tip.
    OneSided {
        /// Where, and by how much.
        found: Trend,
        /// At most allowed, deviations.
        most: f64,
    },
    /// Touched points that were left out lie a little off the bone together.
    SecondSurface(SecondSurface),
    /// The last points hardly fit: the bone moved, or the tool left it.
    Tail(Tail),
    /// The depth scale or the offset is far from what was told of it: another surface than the bone's, skin for instance.
    Prior {
        /// Which, with its unit.
        what: &'static str,
        /// What was found.
        found: f64,
        /// The deviation about 0 that was told.
        told: f64,
    },
    /// The points before and after a place in their order say two poses: the bone moved against the tracker's reference on the way.
    Moved {
        /// Points before the change.
        before: usize,
        /// By how much the two poses differ at the target where they differ most, mm.
        apart_mm: f64,
        /// The square of the difference in its covariance.
        found: f64,
        /// At most allowed.
        most: f64,
    },
}

impl Limits {
    /// Everything in which a registration falls short at these targets; empty where it may be used. Without a target none may.
    pub fn judge<To: Frame, From: Frame>(
        &self,
        found: &SurfaceRegistration<To, From>,
        targets: &[Point<To>],
    ) -> Vec<Refusal> {
        let mut refusals = Vec::new();
        if found.seeds == 0 {
            refusals.push(Refusal::NotSearched);
        } else if found.hits < self.least_hits {
            refusals.push(Refusal::Hits {
                found: found.hits,
                least: self.least_hits,
                fits: found.fits,
            });
        }
        if !found.is_settled {
            refusals.push(Refusal::NotSettled);
        }
        self.noise(found, &mut refusals);
        // Each comparison is written so that a NaN falls short.
        let mut least = |value: f64, least: f64, refusal: Refusal| {
            if value.is_nan() || value < least {
                refusals.push(refusal);
            }
        };
        if let Some(other) = found.others.first() {
            let (margin, apart_mm) = (other.margin, other.apart_mm);
            let refusal = Refusal::Margin {
                found: margin,
                least: self.least_margin,
                apart_mm,
            };
            least(margin, self.least_margin, refusal);
        }
        let share = Refusal::Share {
            found: found.share_kept,
            least: self.least_share,
        };
        least(found.share_kept, self.least_share, share);
        let kept = Refusal::Kept {
            found: found.kept,
            least: self.least_kept,
        };
        least(found.kept, self.least_kept, kept);
        let away = Refusal::FacingAway {
            found: found.share_facing_away,
            most: self.most_facing_away,
        };
        least(-found.share_facing_away, -self.most_facing_away, away);
        let beyond = Refusal::Beyond {
            found: found.share_beyond,
            most: self.most_beyond,
        };
        least(-found.share_beyond, -self.most_beyond, beyond);
        if let Some(ratio) = found.landmark_ratio {
            let refusal = Refusal::Landmarks {
                found: ratio,
                most: self.most_landmark_ratio,
            };
            least(-ratio, -self.most_landmark_ratio, refusal);
        }
        if let Some(halves) = &found.halves {
            let apart = targets.iter().map(|target| halves.apart_mm(*target));
            let refusal = Refusal::Moved {
                before: halves.before,
                apart_mm: apart.fold(0.0, f64::max),
                found: halves.square,
                most: self.most_moved,
            };
            least(-halves.square, -self.most_moved, refusal);
        }
        if let Some(tail) = tail(&found.points).filter(|tail| tail.likelihood > self.most_tail) {
            refusals.push(Refusal::Tail(tail));
        }
        self.trends(found, &mut refusals);
        self.priors(found, &mut refusals);
        self.errors(found, targets, &mut refusals);
        refusals.extend(self.gross_error(found, targets));
        refusals
    }

    /// What residuals go with, beside the noise.
    fn trends<To: Frame, From: Frame>(&self, found: &SurfaceRegistration<To, From>, refusals: &mut Vec<Refusal>) {
        let most = self.most_trend;
        let is_more = |trend: &Trend| trend.deviations.is_nan() || trend.deviations > most;
        let drifted = found
            .drift
            .filter(is_more)
            .map(|found| Refusal::Drifted { found, most });
        let one_sided = found
            .side
            .filter(is_more)
            .map(|found| Refusal::OneSided { found, most });
        let second = found
            .second
            .filter(|second| second.deviations > most)
            .map(Refusal::SecondSurface);
        refusals.extend(drifted.into_iter().chain(one_sided).chain(second));
    }

    /// What was fitted beside the pose, against what was told of it before.
    fn priors<To: Frame, From: Frame>(&self, found: &SurfaceRegistration<To, From>, refusals: &mut Vec<Refusal>) {
        let [scale, offset] = [found.priors.depth_scale, found.priors.offset_mm];
        for (what, found, told) in [
            ("depths are too long by a share of", found.depth_scale, scale),
            ("the bone lies outside of the surface by mm", found.offset_mm, offset),
        ] {
            if found.is_nan() || found.abs() > self.most_prior * told {
                refusals.push(Refusal::Prior { what, found, told });
            }
        }
    }

    /// What one more gross error may do, where there are such.
    fn gross_error<To: Frame, From: Frame>(
        &self,
        found: &SurfaceRegistration<To, From>,
        targets: &[Point<To>],
    ) -> Option<Refusal> {
        // why: without a sign of a gross error the predicted error holds, and 20 clean points would be refused for what is not among them.
        let is_out = |point: &&PointResult| !matches!(point.class, Class::Kept | Class::Beyond);
        let left_out = found.points.iter().filter(is_out).count();
        let each = targets.iter().filter_map(|target| found.gross_error(*target));
        let worst = each.max_by(|a, b| a.target_mm.total_cmp(&b.target_mm))?;
        let is_held = left_out == 0 || worst.target_mm <= self.most_tre_mm;
        (!is_held).then_some(Refusal::GrossError {
            found: worst,
            most_mm: self.most_tre_mm,
            left_out,
        })
    }

    fn noise<To: Frame, From: Frame>(&self, found: &SurfaceRegistration<To, From>, refusals: &mut Vec<Refusal>) {
        let spread = self.noise_sigmas * found.noise_ratio_sigma;
        let (most, least) = (
            self.most_noise_ratio.max(1.0 + spread),
            self.least_noise_ratio.min(1.0 - spread),
        );
        let ratio = found.noise_ratio;
        if ratio.is_nan() || ratio > most {
            refusals.push(Refusal::Noise { found: ratio, most });
        } else if ratio < least {
            refusals.push(Refusal::Quiet { found: ratio, least });
        }
    }

    /// The errors at the targets, and the motions that make them too large.
    fn errors<To: Frame, From: Frame>(
        &self,
        found: &SurfaceRegistration<To, From>,
        targets: &[Point<To>],
        refusals: &mut Vec<Refusal>,
    ) {
        let each = targets.iter().map(|target| found.predicted_tre_mm(*target));
        // What is no number is the worst of all, whichever its sign.
        let each = each.map(|mm| if mm.is_nan() { f64::INFINITY } else { mm });
        let worst = each.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let (target, found_mm) = worst.unwrap_or((0, f64::NAN));
        if found_mm.is_nan() || found_mm > self.most_tre_mm {
            refusals.push(Refusal::Tre {
                target,
                found_mm,
                most_mm: self.most_tre_mm,
            });
        }
        let motions = free(found, targets);
        let too_free = motions
            .into_iter()
            .filter(|motion| motion.deviation_mm.is_nan() || motion.deviation_mm > self.most_tre_mm);
        refusals.extend(too_free.map(Refusal::Free));
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSearched => write!(
                f,
                "one start was followed and nothing searched, so that nothing is known of other poses that fit"
            ),
            Self::NotSettled => write!(f, "the fit did not settle"),
            Self::Noise { found, most } => write!(
                f,
                "residuals are {found:.2} times the noise that was told, at most {most:.2} is accepted: a wrong pose, another bone, a mirrored one, or noise told too small"
            ),
            Self::Quiet { found, least } => write!(
                f,
                "residuals are {found:.2} times the noise that was told, at least {least:.2} is accepted: with noise told that large no wrong pose would be noticed"
            ),
            Self::Margin { found, least, apart_mm } => write!(
                f,
                "another pose, {apart_mm:.1} mm off at the points, costs {found:.1} more; at least {least:.1} is accepted: touch places that tell the two apart"
            ),
            Self::Share { found, least } => write!(
                f,
                "{:.0} % of the points of which the surface says something fit, at least {:.0} % is accepted",
                found * 100.0,
                least * 100.0
            ),
            Self::Kept { found, least } => write!(f, "{found:.0} points fit, at least {least:.0} is accepted"),
            Self::FacingAway { found, most } => write!(
                f,
                "{:.0} % of the beams come from inside the bone, at most {:.0} % is accepted: are beams or sides turned round?",
                found * 100.0,
                most * 100.0
            ),
            Self::Beyond { found, most } => write!(
                f,
                "{:.1} % of the points lie beyond the end of the bone's surface, at most {:.1} % is accepted: does the CT go so far?",
                found * 100.0,
                most * 100.0
            ),
            Self::Tre {
                target,
                found_mm,
                most_mm,
            } => write!(
                f,
                "the error predicted at target {} is {found_mm:.2} mm, at most {most_mm:.2} is accepted",
                target + 1
            ),
            Self::GrossError {
                found,
                most_mm,
                left_out,
            } => write!(
                f,
                "{left_out} points were left out as gross errors, and one more, of {:.1} mm at the place of point {}, would put a target {:.1} mm off, at most {most_mm:.2} is accepted: take more points about it",
                found.error_mm,
                found.point + 1,
                found.target_mm
            ),
            Self::Free(free) => write!(f, "not held: {free}"),
            Self::Hits { found, least, fits } => write!(
                f,
                "{found} of {fits} fits led here, at least {least} is accepted: the search was too sparse to have seen every pose"
            ),
            Self::Tail(tail) => write!(
                f,
                "of the last {} points {:.0} % do not fit, of those before {:.0} %: the bone moved under the reference, or the tool left it; leave them out, or touch the first places again",
                tail.points,
                tail.left_out * 100.0,
                tail.left_out_before * 100.0
            ),
            Self::Prior { what, found, told } => write!(
                f,
                "{what} {found:+.3}, and {told} was told as its deviation: another surface than the bone's (skin?), another bone, or a deviation told too small"
            ),
            Self::Moved {
                before,
                apart_mm,
                found,
                most,
            } => write!(
                f,
                "the first {before} points and those after them say two poses, {apart_mm:.1} mm apart at the target: {found:.0} squares of deviations, at most {most:.0} is accepted: did the bone move under the reference?"
            ),
            Self::Drifted { found, most } => write!(
                f,
                "residuals go with the order of the points: the bone slid by some {:.1} mm under the reference while they were taken, or the tool got worse ({:.1} normal deviations, at most {most:.1} is chance)",
                found.mm, found.deviations
            ),
            Self::OneSided { found, most } => {
                let [x, y, z] = found.towards;
                write!(
                    f,
                    "the points on one side, towards ({x:.1}, {y:.1}, {z:.1}) of the bone's axes, lie {:.1} mm further outside of it than the others ({:.1} normal deviations, at most {most:.1} is chance): soft tissue under the tip?",
                    found.mm, found.deviations
                )
            }
            Self::SecondSurface(second) => write!(
                f,
                "{} of the {} touched points that were left out lie within {:.1} mm of the bone, by the mean of {:.1} mm: they are of a second surface, soft tissue under the tip for instance, and which of the two the bone is they do not say",
                second.points, second.left_out, second.within_mm, second.mm
            ),
            Self::Landmarks { found, most } => write!(
                f,
                "the landmarks' squared misses are {found:.1} times what their errors say, at most {most:.1} is accepted: are they swapped?"
            ),
        }
    }
}
