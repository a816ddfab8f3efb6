//! From a CT to the surface of one bone.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::contrast::contrast;
use crate::enclosed::is_enclosed;
use crate::error::Refused;
use crate::fill::fill;
use crate::model::Unknowns;
use crate::optics::Optics;
use crate::patch::{Lost, Patch, Window, patch};
use crate::place::{Place, Sight, State};
use crate::quadric::{Adjacent, Quadric, normals, quadric};
use crate::region::{Chosen, Cut, IsLabelled, Levels, Region, choose};
use crate::result::{Bone, ScannerFound};
use crate::scanner::{Scanner, by_shared, measure};
use crate::shell::{Edge, Shell, shell};
use crate::sight::{Bare, Judged, sights};
use crate::solve::{covariance, fit};
use crate::voxels::{Crop, Voxels};

/// How a bone is taken from a CT.
pub struct Options<'a> {
    /// Which bone.
    pub region: Region<'a>,
    /// Planes that cut joints.
    pub cuts: &'a [Cut],
    /// Voxels that belong to other bones, by column, row and slice.
    pub excluded: IsLabelled<'a>,
    /// Bone has at least so many HU: for the topology only.
    pub level_hu: f64,
    /// Metal has at least so many HU.
    pub metal_hu: i16,
    /// Vessels and organs with contrast medium have at most so many HU; 0 of a CT without, of which all is bone then.
    pub contrast_hu: f64,
    /// The scanner's blur in the slice's plane and along its normal, where it is known: deviations, mm.
    pub blur_mm: Option<[f64; 2]>,
    /// Threads.
    pub threads: usize,
    /// Whether a surface without cortex is taken, and heard.
    pub takes_no_cortex: bool,
    /// Told from time to time: what is done, and how much of it, from 0 to 1.
    pub progress: Progress<'a>,
}

/// Told what is done, and how much of it, from 0 to 1.
pub type Progress<'a> = &'a (dyn Fn(&'static str, f64) + Sync);

impl Options<'_> {
    /// Of a region, with 200 HU for bone and 3000 HU for metal.
    pub fn of(region: Region<'_>) -> Options<'_> {
        Options {
            region,
            cuts: &[],
            excluded: &|_| false,
            level_hu: 200.0,
            metal_hu: 3000,
            contrast_hu: 450.0,
            blur_mm: None,
            threads: 1,
            takes_no_cortex: false,
            progress: &|_, _| (),
        }
    }
}

/// Places that tell of what is shared: at most, and at least.
const SAMPLE: usize = 400;
const LEAST_SAMPLE: usize = 12;
/// Times that the surface is fitted: the second from normals of the first's.
const PASSES: usize = 2;
/// Residuals of more than this share of the profile's height, beside four deviations of the noise, are no fit.
const MOST_MISFIT: f64 = 0.2;
/// A position of more deviation than this share of the blur is not known.
const MOST_UNSURE: f64 = 0.9;
/// The model's own error of a position as a share of the blur: no blur is a Gaussian and no bone a bent plane.
const MODEL_ERROR: f64 = 0.03;
/// A position off from the middle of those around it by more of its deviations is astray.
const STRAY: f64 = 4.0;
/// The least share of the surface that must be fitted.
const LEAST_KEPT: f64 = 0.25;
/// What is seen of cortex counts by the places within two voxels, or so many mm.
const SIGHT_MM: f64 = 4.0;
/// The most share of a bone's surface that has no cortex.
const MOST_WITHOUT: f64 = 0.6;

/// The most share of bone in the part of the CT about it, which has a margin to each side.
const MOST_BONE: f64 = 0.95;

/// Takes the surface of a bone from a CT.
///
/// # Errors
/// [`Refused`].
pub fn extract(voxels: &dyn Voxels, options: &Options<'_>) -> Result<Bone, Refused> {
    check(options)?;
    let optics = Optics::of(voxels.grid())?;
    let expected = options.blur_mm.unwrap_or(optics.expected_mm());
    let levels = Levels {
        bone_hu: options.level_hu,
        metal_hu: options.metal_hu,
    };
    let margin = 4.0 * expected[0].max(expected[1]) + 6.0;
    let Chosen {
        crop,
        mut mask,
        body,
        listed,
        metal,
    } = choose(voxels, &options.region, options.cuts, options.excluded, levels, margin)?;
    not_all_bone(&crop, &mask, options.level_hu)?;
    (options.progress)("filling", 0.0);
    fill(&crop, &mut mask, options.level_hu);
    let mut shell = shell(&crop, &mask, options.level_hu)?;
    let work = Work {
        crop: &crop,
        optics,
        is_told: options.blur_mm.is_some(),
        threads: options.threads.clamp(1, 64),
        progress: options.progress,
        window: window(&optics, options.metal_hu),
        cuts: options.cuts,
        contrast_hu: options.contrast_hu,
    };
    work.inner_walls(&mut shell, &mask);
    let mut scanner = Scanner::expected(expected, options.blur_mm.is_some());
    let mut corners = shell.corners.clone();
    let mut states = Vec::new();
    let adjacent = Adjacent::new(shell.corners.len(), &shell.triangles);
    for _ in 0..PASSES {
        let quadrics = work.quadrics(&corners, &shell);
        scanner = work.scanner(&quadrics, &shell, &states, expected).unwrap_or(scanner);
        let before = std::mem::take(&mut states);
        states = work.states(&quadrics, &shell, &scanner, &before);
        corners = moved(&corners, &quadrics, &states);
        work.sights(&mut states, &shell, &adjacent);
    }
    work.strays(&mut states, &adjacent);
    let found = ScannerFound::new(&scanner, options.blur_mm.is_some());
    let judged = work.without_bare(&mut states, &shell, &adjacent, options)?;
    let bone = Bone::gather(&shell, &states, found, judged, (body, listed, metal));
    verdict(&bone)?;
    Ok(bone)
}

fn check(options: &Options<'_>) -> Result<(), Refused> {
    let bad = |name, found: String, allowed| Err(Refused::Option { name, found, allowed });
    let level = options.level_hu;
    if !(level > 50.0 && level <= 1500.0) {
        return bad("the threshold of bone, HU,", level.to_string(), "50 to 1500");
    }
    if f64::from(options.metal_hu) < level + 500.0 {
        return bad(
            "the threshold of metal, HU,",
            options.metal_hu.to_string(),
            "500 more than that of bone, and more",
        );
    }
    if !(0.0..=2000.0).contains(&options.contrast_hu) {
        return bad(
            "the most HU of contrast medium",
            options.contrast_hu.to_string(),
            "0 to 2000",
        );
    }
    if let Some(blur) = options.blur_mm
        && !blur.iter().all(|b| (0.1..=5.0).contains(b))
    {
        return bad("the blur, mm,", format!("{blur:?}"), "0.1 to 5 mm");
    }
    if let Region::Labelled { grow_mm, .. } = options.region
        && !(0.0..=20.0).contains(&grow_mm)
    {
        return bad("the labels' growth, mm,", grow_mm.to_string(), "0 to 20");
    }
    Ok(())
}

fn verdict(bone: &Bone) -> Result<(), Refused> {
    let (corners, kept) = (bone.threshold_corners, bone.places.len());
    if (kept as f64) < LEAST_KEPT * corners as f64 || kept < 20 {
        let reasons: Vec<String> = bone
            .lost
            .iter()
            .map(|(why, n)| format!("{n}: {}", why.words()))
            .collect();
        return Err(Refused::Few {
            corners,
            kept,
            least: 100.0 * LEAST_KEPT,
            reasons: reasons.join("; "),
        });
    }
    Ok(())
}

/// Bone is seen beside what is none.
fn not_all_bone(crop: &Crop, mask: &[u8], level: f64) -> Result<(), Refused> {
    let measured = || (0..mask.len()).filter(|at| !crop.is_gap(*at));
    let bone = measured().filter(|at| mask[*at] == 1).count() as f64;
    let share = bone / (measured().count() as f64).max(1.0);
    if share < MOST_BONE {
        return Ok(());
    }
    Err(Refused::AllBone {
        share: 100.0 * share,
        level,
        darkest: measured().map(|at| crop.hu[at]).min().unwrap_or(i16::MIN),
    })
}

fn window(optics: &Optics, metal_hu: i16) -> Window {
    let [plane, axial] = optics.step_mm;
    let mean = (plane * plane * axial).cbrt();
    Window {
        radius_mm: (1.2 * mean).clamp(1.2, 4.0),
        metal_hu,
        step_mm: 0.4 * plane.min(axial),
    }
}

struct Work<'a> {
    crop: &'a Crop,
    optics: Optics,
    is_told: bool,
    threads: usize,
    progress: Progress<'a>,
    window: Window,
    cuts: &'a [Cut],
    contrast_hu: f64,
}

impl Work<'_> {
    /// Marks corners of the walls of cavities that are open somewhere.
    fn inner_walls(&self, shell: &mut Shell, mask: &[u8]) {
        let normals = normals(&shell.corners, &shell.triangles);
        let corners = &shell.corners;
        let inner = self.parallel("inner walls", corners.len(), |i, _| {
            is_enclosed(self.crop, mask, &corners[i], &normals[i])
        });
        for (edge, _) in shell.edge.iter_mut().zip(inner).filter(|(_, is_inner)| *is_inner) {
            if *edge == Edge::None {
                *edge = Edge::Inner;
            }
        }
    }

    fn quadrics(&self, corners: &[Vector3<f64>], shell: &Shell) -> Vec<Option<Quadric>> {
        let adjacent = Adjacent::new(corners.len(), &shell.triangles);
        // Where the CT or the region ends a lid closes the shell: it says nothing of how the bone's surface lies.
        let is_lid = |t: &&[u32; 3]| t.iter().any(|i| shell.edge[*i as usize] != Edge::None);
        let walls: Vec<[u32; 3]> = shell.triangles.iter().filter(|t| !is_lid(t)).copied().collect();
        let normals = normals(corners, &walls);
        let [plane, axial] = self.optics.step_mm;
        // Wide enough for the steps of slices, and as narrow as a bone's edges ask.
        let reach = (1.6 * (plane * plane * axial).cbrt())
            .max(1.3 * plane.max(axial))
            .max(2.0);
        self.parallel("normals", corners.len(), |i, found| {
            // Where a sheared grid leaves too few corners within reach, those a little farther do.
            quadric(corners, &normals, &adjacent, i, reach, found)
                .or_else(|| quadric(corners, &normals, &adjacent, i, 1.6 * reach, found))
        })
    }

    fn patch(&self, quadric: &Quadric, blur: ([f64; 2], f64)) -> Result<Patch, Lost> {
        patch(self.crop, quadric, &self.optics.covariance(blur.0), blur, &self.window)
    }

    /// What all places share, from some of them, spread evenly.
    fn scanner(
        &self,
        quadrics: &[Option<Quadric>],
        shell: &Shell,
        before: &[State],
        expected: [f64; 2],
    ) -> Option<Scanner> {
        (self.progress)("blur of the scanner", 0.0);
        let expected = Scanner::expected(expected, self.is_told);
        // A vessel's wall tells of no cortex.
        let is_bare = |i: usize| matches!(before.get(i), Some(Ok(place)) if place.sight == Sight::Bare);
        let fit_for = |i: &usize| shell.edge[*i] == Edge::None && quadrics[*i].is_some() && !is_bare(*i);
        let all: Vec<usize> = (0..quadrics.len()).filter(fit_for).collect();
        let every = (all.len() / SAMPLE).max(1);
        let sample: Vec<Quadric> = all.iter().step_by(every).filter_map(|i| quadrics[*i]).collect();
        measure(expected, LEAST_SAMPLE, |blur| {
            let made = sample.iter().filter_map(|quadric| self.patch(quadric, blur).ok());
            made.filter(|patch| !patch.is_short).collect()
        })
    }

    fn states(&self, quadrics: &[Option<Quadric>], shell: &Shell, scanner: &Scanner, before: &[State]) -> Vec<State> {
        let name = if before.is_empty() { "first fit" } else { "fit" };
        self.parallel(name, quadrics.len(), |i, _| {
            match shell.edge[i] {
                Edge::End => return Err(Lost::End),
                Edge::Cut => return Err(Lost::Cut),
                Edge::Inner => return Err(Lost::Inner),
                Edge::None => {}
            }
            let quadric = quadrics[i].ok_or(Lost::Rough)?;
            let start = before.get(i).and_then(|state| state.as_ref().ok());
            self.place(&quadric, scanner, start)
        })
    }

    /// From `start` on, a fit of nearly the same surface, where there is one.
    fn place(&self, quadric: &Quadric, scanner: &Scanner, start: Option<&Place>) -> State {
        let patch = self.patch(quadric, (scanner.blur_mm, scanner.kurtosis))?;
        let (priors, noise) = (scanner.wide_priors(), scanner.noise);
        let start = start.map(|p| {
            let outer = (p.mm - quadric.foot).dot(&quadric.normal);
            Unknowns::new(outer, p.thickness_mm.ln(), p.cortex_hu, p.inside_hu, p.tissue_hu)
        });
        let fit = fit(&patch, &priors, noise.hu, start).ok_or(Lost::Misfit)?;
        let [outer, _, cortex, inside, tissue] = fit.at.into();
        let thickness = fit.at[1].exp();
        let s = patch.place.blur_mm;
        let most = patch.samples.iter().map(|s| s.hu).fold(f64::NEG_INFINITY, f64::max);
        let allowed = MOST_MISFIT * (most - tissue).max(0.0) + 4.0 * noise.hu;
        if fit.residual_hu2.sqrt() > allowed || cortex < tissue || outer.abs() > 4.0 * s + 1.0 {
            return Err(Lost::Misfit);
        }
        // Where the model fits worse than the noise says, it is as if there were more noise.
        let worse = (fit.residual_hu2 / (noise.hu * noise.hu)).max(1.0);
        let full = covariance(&patch, &priors, &noise, &fit).ok_or(Lost::Unsure)?;
        let shared = by_shared(&patch, &priors, &fit, noise.hu).ok_or(Lost::Unsure)?;
        let by = shared.row(0).transpose();
        let own = (full[(0, 0)] * worse + (MODEL_ERROR * s).powi(2)).sqrt();
        let common = (by.transpose() * scanner.covariance * by)[0].max(0.0).sqrt();
        // A NaN is unsure.
        let is_sure = own.hypot(common) < MOST_UNSURE * s;
        if !is_sure {
            return Err(Lost::Unsure);
        }
        // Before a cut stands the blurred edge of what is behind it, whose own surface lies there.
        let mm = quadric.foot + quadric.normal * outer;
        if self.cuts.iter().any(|cut| cut.holds(&mm)) {
            return Err(Lost::Cut);
        }
        Ok(Place {
            mm,
            normal: quadric.normal,
            outer_mm: outer,
            deviation_mm: own,
            shared_mm: common,
            thickness_mm: thickness,
            thickness_log_deviation: full[(1, 1)].max(0.0).sqrt(),
            cortex_hu: cortex,
            inside_hu: inside,
            tissue_hu: tissue,
            contrast: contrast(&patch, &priors, &noise, &fit, self.contrast_hu),
            sight: Sight::Unseen,
        })
    }

    /// Judges what is seen of cortex, and tells of the pieces that have none.
    fn sights(&self, states: &mut [State], shell: &Shell, adjacent: &Adjacent) -> Vec<Bare> {
        let [plane, axial] = self.optics.step_mm;
        let reach = (2.0 * plane.max(axial)).max(SIGHT_MM);
        let (of, bare) = sights(states, &shell.triangles, adjacent, reach);
        for (state, sight) in states.iter_mut().zip(of) {
            if let Ok(place) = state {
                place.sight = sight;
            }
        }
        bare
    }

    /// Leaves out the places without cortex, unless a person wants them, or a label map says that they are bone.
    fn without_bare(
        &self,
        states: &mut [State],
        shell: &Shell,
        adjacent: &Adjacent,
        options: &Options<'_>,
    ) -> Result<Judged, Refused> {
        let bare = self.sights(states, shell, adjacent);
        let share = |of: &dyn Fn(Sight) -> bool| {
            let fitted = states.iter().filter_map(|s| s.as_ref().ok());
            let (all, those) = fitted.fold((0.0_f64, 0.0), |(n, k), p| {
                (n + 1.0, k + f64::from(u8::from(of(p.sight))))
            });
            those / all.max(1.0)
        };
        let without_cortex = share(&|sight| sight != Sight::Cortex);
        let bare_share = share(&|sight| sight == Sight::Bare);
        if bare_share > MOST_WITHOUT && !options.takes_no_cortex {
            return Err(Refused::NoCortex {
                share: 100.0 * bare_share,
                most: self.contrast_hu,
            });
        }
        // why: a thin cortex in thick slices is not told from contrast medium, the crest above all; where a label map tells bone from vessels,
        // that counts more.
        let is_named = matches!(options.region, Region::Labelled { .. });
        if options.takes_no_cortex || is_named {
            return Ok(Judged {
                bare: Vec::new(),
                without_cortex,
                is_heard: true,
            });
        }
        for state in states.iter_mut() {
            if matches!(state, Ok(place) if place.sight == Sight::Bare) {
                *state = Err(Lost::Bare);
            }
        }
        Ok(Judged {
            bare,
            without_cortex,
            is_heard: false,
        })
    }

    /// Places that lie off from those around them lose their position; those without one that lie among others take theirs.
    fn strays(&self, states: &mut [State], adjacent: &Adjacent) {
        let before: Vec<State> = states.to_vec();
        for (i, state) in states.iter_mut().enumerate() {
            let Ok(place) = state else { continue };
            let around: Vec<&Place> = adjacent
                .of(i)
                .iter()
                .filter_map(|k| before[*k as usize].as_ref().ok())
                .collect();
            if around.len() < 3 {
                continue;
            }
            let middle = ::fit::median(around.iter().map(|p| (p.mm - place.mm).dot(&place.normal)).collect());
            let expected = ::fit::median(around.iter().map(|p| p.deviation_mm).collect());
            // Corners around lie lower on a bent surface: by the square of their distance over twice the radius, which this allows for.
            let bend = ::fit::median(around.iter().map(|p| (p.mm - place.mm).norm()).collect()) * 0.35;
            if middle.abs() > STRAY * place.deviation_mm.hypot(expected) + bend {
                *state = Err(Lost::Stray);
            }
        }
    }

    /// The same work for each of `count` numbers, by threads; the result does not depend on how many.
    fn parallel<T: Send>(
        &self,
        name: &'static str,
        count: usize,
        work: impl Fn(usize, &mut Vec<u32>) -> T + Sync,
    ) -> Vec<T> {
        let share = count.div_ceil(self.threads).max(1);
        let progress = self.progress;
        let chunk = |first: usize| {
            let (mut found, end) = (Vec::new(), (first + share).min(count));
            let mut results = Vec::with_capacity(end.saturating_sub(first));
            for i in first..end {
                if first == 0 && i % 1024 == 0 {
                    progress(name, i as f64 / share as f64);
                }
                results.push(work(i, &mut found));
            }
            results
        };
        let chunk = &chunk;
        std::thread::scope(|scope| {
            let running: Vec<_> = (0..count)
                .step_by(share)
                .map(|first| scope.spawn(move || chunk(first)))
                .collect();
            let mut all = Vec::with_capacity(count);
            for thread in running {
                match thread.join() {
                    Ok(part) => all.extend(part),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            all
        })
    }
}

/// The corners where they were found; those without a position of their own go with the mean of those around them, so that normals beside
/// them stay what they are.
fn moved(corners: &[Vector3<f64>], quadrics: &[Option<Quadric>], states: &[State]) -> Vec<Vector3<f64>> {
    let known: Vec<f64> = states
        .iter()
        .filter_map(|s| s.as_ref().ok())
        .map(|p| p.outer_mm)
        .collect();
    let typical = ::fit::median(known);
    let mut sums: HashMap<usize, Vector3<f64>> = HashMap::new();
    for (i, (state, quadric)) in states.iter().zip(quadrics).enumerate() {
        let to = match (state, quadric) {
            (Ok(place), _) => place.mm,
            (Err(_), Some(quadric)) => quadric.foot + quadric.normal * typical,
            (Err(_), None) => corners[i],
        };
        sums.insert(i, to);
    }
    (0..corners.len()).map(|i| sums[&i]).collect()
}
