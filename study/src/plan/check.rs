//! From what a study file says to what is done.

use std::ops::RangeInclusive;
use std::path::Path;

use geometry::Point;
use phantom::Phantom;

use super::at::At;
use super::error::PlanError;
use super::raw::{RawBeads, RawDials, RawStudy};
use super::surface;
use super::sweep::{self, Sweep};
use super::tissue;
use super::{
    Beads, Breathing, Bump, Calibration, Ct, Dials, Display, Localizer, Marker, Planted, PlantedIn, Stratum, Touch,
};

/// The most operations of a stratum.
const MOST_OPERATIONS: u64 = 100_000;
/// Beads nearer than this, or in a line to within it, determine no place.
const LEAST_SPREAD_MM: f64 = 5.0;
/// Turns, degrees.
const TURN: RangeInclusive<f64> = -360.0..=360.0;
/// How far a localizer may be moved along each axis, mm.
const FAR: RangeInclusive<f64> = -20_000.0..=20_000.0;
/// Names of the skin's beads that face the operator: the places that are touched most easily, all on one side.
const FRONT: [usize; 4] = [0, 1, 4, 5];
/// In the order in which more of them are touched: the first three lie far apart already.
const SPREAD: [usize; 7] = [5, 3, 6, 7, 1, 2, 4];

/// The strata of one file, and the sweep that the last of them are; `before` strata stand before them in the plan.
pub(super) fn strata(path: &Path, text: &str, before: usize) -> Result<(Vec<Stratum>, Option<Sweep>), PlanError> {
    let raw: RawStudy = toml::from_str(text).map_err(|error| PlanError::Grammar {
        path: path.to_owned(),
        why: error.to_string(),
    })?;
    let of_file = At {
        path,
        of: "the file".to_owned(),
    };
    // Also where no stratum uses it.
    display(&of_file, raw.display.as_deref())?;
    let all = &raw.all;
    if all.name.is_some() || all.operations.is_some() {
        return Err(of_file.wrong(
            "all",
            "name or operations",
            "strata have names; operations of all stand at the top",
        ));
    }
    let swept = raw.sweep.as_ref();
    let swept = swept.map(|table| sweep::strata(path, table, before + raw.stratum.len()));
    let (sweep, cells) = swept.transpose()?.unzip();
    let all = raw.stratum.iter().chain(cells.iter().flatten());
    let strata: Result<Vec<Stratum>, PlanError> = all.map(|one| stratum(path, &raw, one)).collect();
    Ok((strata?, sweep))
}

fn stratum(path: &Path, raw: &RawStudy, one: &RawDials) -> Result<Stratum, PlanError> {
    let name = one.name.clone().unwrap_or_default();
    let at = At {
        path,
        of: format!("stratum {name:?}"),
    };
    if !is_name(&name) {
        return Err(at.wrong("name", &name, "1 to 40 of the characters a-z, A-Z, 0-9, - and _"));
    }
    let operations = at.within("operations", [one.operations, raw.operations], 100, 1..=MOST_OPERATIONS)?;
    let shown = [&one.display, &raw.all.display, &raw.display]
        .into_iter()
        .flatten()
        .next();
    Ok(Stratum {
        own_name: name.clone(),
        name,
        seed: raw.seed.unwrap_or(1),
        operations,
        dials: Dials {
            display: display(&at, shown.map(String::as_str))?,
            ..dials(&at, one, &raw.all, operations)?
        },
    })
}

/// Whether a stratum can be called so, and a file whose strata are told by it.
pub(super) fn is_name(name: &str) -> bool {
    let is_of_name = |c: u8| c.is_ascii_alphanumeric() || b"-_".contains(&c);
    (1..=40).contains(&name.len()) && name.bytes().all(is_of_name)
}

fn display(at: &At<'_>, word: Option<&str>) -> Result<Display, PlanError> {
    match word {
        None | Some("sight") => Ok(Display::Sight),
        Some("pixels") => Ok(Display::Pixels),
        Some(other) => Err(at.wrong("display", other, "\"sight\" or \"pixels\" is allowed")),
    }
}

fn dials(at: &At<'_>, own: &RawDials, all: &RawDials, operations: u64) -> Result<Dials, PlanError> {
    let ct = ct(at, own, all, operations)?;
    Ok(Dials {
        targets: targets(at, own.targets.as_ref().or(all.targets.as_ref()))?,
        display: Display::Sight,
        radius_mm: at.within("radius_mm", [own.radius_mm, all.radius_mm], 5.0, 0.5..=50.0)?,
        beads: beads(at, &own.beads, &all.beads)?,
        surface: surface::surface(at, own, all)?,
        bead_mm: at.within(
            "beads.diameter_mm",
            [own.beads.diameter_mm, all.beads.diameter_mm],
            2.0,
            1.0..=6.0,
        )?,
        marker: marker(at, own, all)?,
        reference_deg: at.within(
            "reference.turned_deg",
            [own.reference.turned_deg, all.reference.turned_deg],
            0.0,
            TURN,
        )?,
        localizer: localizer(at, own, all)?,
        calibration: calibration(at, own, all)?,
        touch: touch(at, own, all)?,
        check_max_mm: at.within("check.max_mm", [own.check.max_mm, all.check.max_mm], 4.0, 0.1..=100.0)?,
        occlusion: occlusion(at, own, all)?,
        breathing: breathing(at, own, all)?,
        tissue: tissue::tissue(at, own, all)?,
        bump: bump(at, own, all)?,
        planted: planted(at, own, all)?,
        understated: at.within(
            "planted.understated",
            [own.planted.understated, all.planted.understated],
            1.0,
            0.1..=10.0,
        )?,
        ct,
    })
}

fn ct(at: &At<'_>, own: &RawDials, all: &RawDials, operations: u64) -> Result<Ct, PlanError> {
    let spacing_mm = own.ct.spacing_mm.or(all.ct.spacing_mm).unwrap_or([1.0; 3]);
    for mm in spacing_mm {
        at.within("ct.spacing_mm", [Some(mm), None], mm, 0.1..=10.0)?;
    }
    let is_fresh = own.ct.fresh.or(all.ct.fresh).unwrap_or(false);
    let images = at.within("ct.images", [own.ct.images, all.ct.images], 4, 1..=1000)?;
    Ok(Ct {
        spacing_mm,
        noise_hu: at.within("ct.noise_hu", [own.ct.noise_hu, all.ct.noise_hu], 15.0, 0.0..=200.0)?,
        images: if is_fresh { operations } else { images.min(operations) },
    })
}

fn targets(at: &At<'_>, names: Option<&Vec<String>>) -> Result<Vec<usize>, PlanError> {
    let patient = Phantom::new(phantom::DEFAULT_SEED);
    let known: Vec<&str> = patient.targets().iter().map(|target| target.name.as_str()).collect();
    let Some(names) = names else {
        return Ok((0..known.len()).collect());
    };
    if names.is_empty() {
        return Err(at.wrong("targets", names, "an operation needs a target"));
    }
    let mut found = Vec::new();
    for name in names {
        let place = known.iter().position(|one| one == name);
        let place = place.filter(|place| !found.contains(place));
        found.push(
            place.ok_or_else(|| at.wrong("targets", name, format!("each of {} at most once", known.join(", "))))?,
        );
    }
    Ok(found)
}

fn beads(at: &At<'_>, own: &RawBeads, all: &RawBeads) -> Result<Beads, PlanError> {
    if let Some(places) = own.at_mm.as_ref().or(all.at_mm.as_ref()) {
        return placed(at, places);
    }
    let order: &[usize] = match own.places.as_deref().or(all.places.as_deref()).unwrap_or("spread") {
        "spread" => &SPREAD,
        "front" => &FRONT,
        other => return Err(at.wrong("beads.places", other, "\"spread\" or \"front\" is allowed")),
    };
    let usual = order.len().min(6) as u64;
    let touched = at.within(
        "beads.touched",
        [own.touched, all.touched],
        usual,
        3..=order.len() as u64,
    )?;
    // At most seven.
    Ok(Beads::OnSkin(order[..touched as usize].to_vec()))
}

/// Beads at places of the file's own: in the CT, not in the air, and no line.
fn placed(at: &At<'_>, places: &[[f64; 3]]) -> Result<Beads, PlanError> {
    const KEY: &str = "beads.at_mm";
    if !(3..=40).contains(&places.len()) {
        return Err(at.wrong(KEY, places.len(), "3 to 40 beads are needed"));
    }
    let patient = Phantom::new(phantom::DEFAULT_SEED);
    let grid = patient.grid([1.0; 3]);
    let grid = grid.map_err(|error| at.wrong(KEY, "a patient without a grid", error.to_string()))?;
    for (number, &[x, y, z]) in (1..).zip(places) {
        let p = Point::new(x, y, z);
        let is_in_ct = [x, y, z].iter().all(|mm| mm.is_finite()) && grid.holds(p);
        if !is_in_ct {
            return Err(at.wrong(KEY, [x, y, z], format!("bead {number} lies outside the CT")));
        }
        let steps = [
            [0.0; 3],
            [5.0, 0.0, 0.0],
            [-5.0, 0.0, 0.0],
            [0.0, 5.0, 0.0],
            [0.0, -5.0, 0.0],
        ];
        let is_air = |[a, b, c]: [f64; 3]| patient.hu(Point::new(x + a, y + b, z + c)) <= phantom::AIR_HU;
        if steps.into_iter().all(is_air) {
            return Err(at.wrong(
                KEY,
                [x, y, z],
                format!("bead {number} hangs in the air beside the patient"),
            ));
        }
    }
    let points: Vec<Point<geometry::Ct>> = places.iter().map(|&[x, y, z]| Point::new(x, y, z)).collect();
    let near = |i: usize, j: usize| points[i].distance(points[j]) < LEAST_SPREAD_MM;
    if let Some((i, j)) = pairs(points.len()).find(|&(i, j)| near(i, j)) {
        return Err(at.wrong(KEY, [i + 1, j + 1], "these two beads are nearer than 5 mm"));
    }
    let is_line = |(i, j): (usize, usize)| {
        let along = points[j] - points[i];
        let off = |p: &Point<geometry::Ct>| along.cross(*p - points[i]).norm() / along.norm();
        points.iter().all(|p| off(p) < LEAST_SPREAD_MM)
    };
    match pairs(points.len()).any(is_line) {
        true => Err(at.wrong(
            KEY,
            places,
            "all beads lie on a line to within 5 mm, which determines no place",
        )),
        false => Ok(Beads::At(places.to_vec())),
    }
}

fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

fn marker(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Marker, PlanError> {
    let (own, all) = (&own.marker, &all.marker);
    Ok(Marker {
        // At most 32.
        emitters: at.within("marker.emitters", [own.emitters, all.emitters], 24, 3..=32)? as usize,
        radius_mm: at.within("marker.radius_mm", [own.radius_mm, all.radius_mm], 50.0, 5.0..=200.0)?,
        width: at.within("marker.width", [own.width, all.width], 1.0, 0.001..=1.0)?,
        cone_deg: at.within("marker.cone_deg", [own.cone_deg, all.cone_deg], 75.0, 30.0..=180.0)?,
        made_mm: at.within("marker.made_mm", [own.made_mm, all.made_mm], 0.2, 0.0..=2.0)?,
    })
}

fn localizer(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Localizer, PlanError> {
    let (own, all) = (&own.localizer, &all.localizer);
    let latency_ms = at.within(
        "localizer.latency_ms",
        [own.latency_ms, all.latency_ms],
        0.0,
        0.0..=1000.0,
    )?;
    let across_mm = at.within("localizer.across_mm", [own.across_mm, all.across_mm], 0.1, 0.005..=5.0)?;
    let depth_mm = at.within("localizer.depth_mm", [own.depth_mm, all.depth_mm], 0.15, 0.005..=5.0)?;
    if depth_mm / across_mm > 50.0 || across_mm / depth_mm > 50.0 {
        return Err(at.wrong("localizer.depth_mm", depth_mm, "within a factor of 50 of across_mm"));
    }
    let moved_mm = own.moved_mm.or(all.moved_mm).unwrap_or_default();
    for mm in moved_mm {
        at.within("localizer.moved_mm", [Some(mm), None], mm, FAR)?;
    }
    Ok(Localizer {
        turned_deg: at.within("localizer.turned_deg", [own.turned_deg, all.turned_deg], 0.0, TURN)?,
        moved_mm,
        across_mm,
        depth_mm,
        rate_hz: at.within("localizer.rate_hz", [own.rate_hz, all.rate_hz], 60.0, 15.0..=1000.0)?,
        latency_s: latency_ms / 1e3,
        uptime_s: at.within("localizer.uptime_s", [own.uptime_s, all.uptime_s], 0.0, 0.0..=1e8)?,
    })
}

fn calibration(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Calibration, PlanError> {
    let (own, all) = (&own.calibration, &all.calibration);
    let frames = [own.marker_frames, all.marker_frames];
    Ok(Calibration {
        marker_frames: at.within("calibration.marker_frames", frames, 150, 20..=2000)?,
        pivot_s: at.within("calibration.pivot_s", [own.pivot_s, all.pivot_s], 12.0, 2.0..=60.0)?,
        seat_mm: at.within("calibration.seat_mm", [own.seat_mm, all.seat_mm], 0.05, 0.0..=1.0)?,
        seat_deg: at.within("calibration.seat_deg", [own.seat_deg, all.seat_deg], 0.02, 0.0..=1.0)?,
    })
}

fn touch(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Touch, PlanError> {
    let (own, all) = (&own.touch, &all.touch);
    Ok(Touch {
        error_mm: at.within("touch.error_mm", [own.error_mm, all.error_mm], 0.3, 0.0..=5.0)?,
        stated_mm: at.within("touch.stated_mm", [own.stated_mm, all.stated_mm], 0.3, 0.01..=5.0)?,
        tremor_mm: at.within("touch.tremor_mm", [own.tremor_mm, all.tremor_mm], 0.05, 0.0..=1.0)?,
        seconds: at.within("touch.seconds", [own.seconds, all.seconds], 0.6, 0.2..=10.0)?,
    })
}

fn occlusion(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Option<[f64; 2]>, PlanError> {
    let (own, all) = (&own.occlusion, &all.occlusion);
    let share = at.within("occlusion.share", [own.share, all.share], 0.0, 0.0..=0.9)?;
    let every_s = at.within("occlusion.every_s", [own.every_s, all.every_s], 10.0, 0.5..=3600.0)?;
    Ok((share > 0.0).then_some([share, every_s]))
}

fn breathing(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Option<Breathing>, PlanError> {
    let (own, all) = (&own.breathing, &all.breathing);
    let breathing = Breathing {
        mm: at.within("breathing.mm", [own.mm, all.mm], 0.0, 0.0..=50.0)?,
        period_s: at.within("breathing.period_s", [own.period_s, all.period_s], 4.0, 0.5..=60.0)?,
    };
    Ok((breathing.mm > 0.0).then_some(breathing))
}

fn bump(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Option<Bump>, PlanError> {
    let (own, all) = (&own.bump, &all.bump);
    let bump = Bump {
        share: at.within("bump.share", [own.share, all.share], 0.0, 0.0..=1.0)?,
        mm: at.within("bump.mm", [own.mm, all.mm], 3.0, 0.0..=100.0)?,
        deg: at.within("bump.deg", [own.deg, all.deg], 0.0, 0.0..=45.0)?,
    };
    Ok((bump.share > 0.0).then_some(bump))
}

fn planted(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Option<Planted>, PlanError> {
    let (own, all) = (&own.planted, &all.planted);
    let mm = at.within("planted.mm", [own.mm, all.mm], 0.0, 0.0..=20.0)?;
    let link = match own.link.as_deref().or(all.link.as_deref()) {
        None if mm == 0.0 => return Ok(None),
        None => return Err(at.wrong("planted.mm", mm, "planted.link must say in which link")),
        Some("tool") => PlantedIn::Tool,
        Some("registration") => PlantedIn::Registration,
        Some(other) => return Err(at.wrong("planted.link", other, "\"tool\" or \"registration\" is allowed")),
    };
    Ok(Some(Planted { link, mm }))
}
