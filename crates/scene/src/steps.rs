//! `[steps]`: what is calibrated, registered and checked while the run goes on, step by step.

use std::path::PathBuf;

use geometry::{Ct, Point};
use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid, number, point, repeated};

/// Most points to be touched.
const MOST_POINTS: usize = 32;
/// The fewest points of a registration, and of a check.
const FEWEST_POINTS: usize = 3;
/// Two points that are nearer than this cannot be told apart with a pointer, mm.
pub const APART_MM: f64 = 5.0;

/// `[steps]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawSteps {
    /// How the tool is calibrated; absent: it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibrate: Option<Calibrating>,
    /// The drawing of the calibration base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawing: Option<String>,
    /// What is touched to register the patient, in this order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<RawKnownPoint>>,
    /// Or the beads of `calib beads`, in any order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beads: Option<String>,
    /// What is touched to check the registration; absent: it is not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub check_points: Option<Vec<RawKnownPoint>>,
    /// For how long the instrument is turned, s.
    pub turn_s: f64,
    /// For how long it is held still at a touch and in the seat, s.
    pub touch_s: f64,
}

impl Default for RawSteps {
    fn default() -> Self {
        Self {
            calibrate: None,
            drawing: None,
            points: None,
            beads: None,
            check_points: None,
            turn_s: 20.0,
            touch_s: 1.0,
        }
    }
}

/// A point whose place in the CT is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawKnownPoint {
    /// For people.
    pub name: String,
    /// LPS mm.
    pub ct_mm: [f64; 3],
}

/// How the tool is calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Calibrating {
    /// Its tip by pivoting; the direction of its shaft is the scene's own.
    Pivot,
    /// Its tip by pivoting, its shaft by spinning.
    PivotAndSpin,
    /// In its seat on the calibration base, which is touched with its own tip.
    Base,
}

/// What is calibrated, registered and checked.
#[derive(Debug, Clone, PartialEq)]
pub struct StepsSpec {
    /// How the tool is calibrated; `None`: it is not.
    pub calibrate: Option<Calibrating>,
    /// The drawing of the calibration base, with [`Calibrating::Base`].
    pub drawing: Option<PathBuf>,
    /// How the patient is registered; `None`: not here.
    pub register: Option<Registering>,
    /// What is touched to check the registration; empty: it is not checked. At least three else.
    pub check: Vec<KnownPoint>,
    /// For how long the instrument is turned, s.
    pub turn_s: f64,
    /// For how long it is held still, s.
    pub touch_s: f64,
}

/// How the patient is registered.
#[derive(Debug, Clone, PartialEq)]
pub enum Registering {
    /// By points that are touched in this order; at least three.
    Points(Vec<KnownPoint>),
    /// By the beads in this file, touched in any order.
    Beads(PathBuf),
}

/// A point whose place in the CT is known.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownPoint {
    /// For people: 1 to 40 bytes.
    pub name: String,
    /// Where it is.
    pub place: Point<Ct>,
}

/// Checks the table of a scene whose tracker sees emitters or not, and reads a calibration and a registration from files or not.
pub(super) fn checked(steps: Option<&RawSteps>, has_chain: bool, has_files: [bool; 2]) -> Checked<Option<StepsSpec>> {
    let Some(steps) = steps else { return Ok(None) };
    if !has_chain {
        let allowed = "no such table unless tracker.source is \"operating-room\", \"emitters\" or \"markers\"";
        return Err(invalid("steps", "a table", allowed));
    }
    files_of(steps, has_files)?;
    let path = |key: &str, path: &Option<String>| match path.as_deref() {
        Some("") => Err(invalid(format!("steps.{key}"), "\"\"", "the path of a file")),
        path => Ok(path.map(PathBuf::from)),
    };
    let drawing = path("drawing", &steps.drawing)?;
    match (steps.calibrate, &drawing) {
        (Some(Calibrating::Base), None) => {
            return Err(invalid("steps.drawing", "nothing", "the file of the base's drawing"));
        }
        (Some(Calibrating::Base), Some(_)) | (_, None) => {}
        (_, Some(drawing)) => {
            let allowed = "no drawing unless steps.calibrate = \"base\"";
            return Err(invalid("steps.drawing", format!("{}", drawing.display()), allowed));
        }
    }
    let register = match (&steps.points, path("beads", &steps.beads)?) {
        (Some(_), Some(beads)) => {
            let allowed = "either steps.points or steps.beads";
            return Err(invalid("steps.beads", format!("{}", beads.display()), allowed));
        }
        (Some(points), None) => Some(Registering::Points(known("points", points)?)),
        (None, beads) => beads.map(Registering::Beads),
    };
    let check = steps.check_points.as_deref();
    let check = check
        .map(|points| known("check_points", points))
        .transpose()?
        .unwrap_or_default();
    if let Some(Registering::Points(points)) = &register {
        others(points, &check)?;
    }
    let spec = StepsSpec {
        calibrate: steps.calibrate,
        drawing,
        register,
        check,
        turn_s: number("steps.turn_s", steps.turn_s, 2.0..=120.0, "s")?,
        touch_s: number("steps.touch_s", steps.touch_s, 0.3..=10.0, "s")?,
    };
    if spec.calibrate.is_none() && spec.register.is_none() && spec.check.is_empty() {
        let allowed = "one of calibrate, points, beads and check_points at least";
        return Err(invalid("steps", "none of them", allowed));
    }
    Ok(Some(spec))
}

/// What is made goes into a file that the tracker reads.
fn files_of(steps: &RawSteps, [has_calibration, has_registration]: [bool; 2]) -> Checked<()> {
    let registration = ("registration", has_registration);
    let needs = [
        ("calibrate", steps.calibrate.is_some(), ("calibration", has_calibration)),
        ("points", steps.points.is_some(), registration),
        ("beads", steps.beads.is_some(), registration),
        ("check_points", steps.check_points.is_some(), registration),
    ];
    match needs
        .into_iter()
        .find(|(_, is_asked, (_, is_there))| *is_asked && !is_there)
    {
        None => Ok(()),
        Some((key, _, (table, _))) => {
            let allowed =
                format!("this key only with [tracker.{table}] file, which is the file that is made or checked");
            Err(invalid(format!("steps.{key}"), "no such file", allowed))
        }
    }
}

/// A point that the registration was made of lies near its place whatever that is worth: a check takes others.
fn others(points: &[KnownPoint], check: &[KnownPoint]) -> Checked<()> {
    for (i, one) in check.iter().enumerate() {
        if let Some(same) = points.iter().find(|point| point.place.distance(one.place) < APART_MM) {
            let found = format!(
                "{:.1} mm from {:?} of steps.points",
                same.place.distance(one.place),
                same.name
            );
            let allowed = format!("at least {APART_MM} mm from all points that the patient is registered by");
            return Err(invalid(format!("steps.check_points.{i}.ct_mm"), found, allowed));
        }
    }
    Ok(())
}

fn known(table: &str, raw: &[RawKnownPoint]) -> Checked<Vec<KnownPoint>> {
    let key = |i: usize, name: &str| format!("steps.{table}.{i}.{name}");
    if !(FEWEST_POINTS..=MOST_POINTS).contains(&raw.len()) {
        let allowed = format!("{FEWEST_POINTS} to {MOST_POINTS} points");
        return Err(invalid(format!("steps.{table}"), raw.len(), allowed));
    }
    let mut points: Vec<KnownPoint> = Vec::with_capacity(raw.len());
    for (i, one) in raw.iter().enumerate() {
        let is_name =
            !one.name.is_empty() && one.name.len() <= 40 && !one.name.chars().any(|c| c.is_control() || c == ',');
        if !is_name {
            let allowed = "1 to 40 bytes without commas and control characters";
            return Err(invalid(key(i, "name"), format!("{:?}", one.name), allowed));
        }
        let place: Point<Ct> = point(&key(i, "ct_mm"), one.ct_mm)?;
        if let Some(near) = points.iter().find(|other| other.place.distance(place) < APART_MM) {
            let found = format!("{:.1} mm from {:?}", near.place.distance(place), near.name);
            return Err(invalid(
                key(i, "ct_mm"),
                found,
                format!("at least {APART_MM} mm from all others"),
            ));
        }
        points.push(KnownPoint {
            name: one.name.clone(),
            place,
        });
    }
    match repeated(points.iter().map(|point| point.name.as_str())) {
        Some((i, name)) => Err(invalid(
            key(i, "name"),
            format!("{name:?} a second time"),
            "a name of its own",
        )),
        None => Ok(points),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use std::path::Path;

    const LINKS: &str = "[tracker]\nsource = \"operating-room\"\n[tracker.calibration]\nfile = \"tool.json\"\n\
                         [tracker.registration]\nfile = \"registration.json\"\n[steps]\n";
    const THREE: &str = "[{ name = \"a\", ct_mm = [0, 0, 0] }, { name = \"b\", ct_mm = [9, 0, 0] }, \
                         { name = \"c\", ct_mm = [0, 9, 0] }]";

    const OTHERS: &str = "[{ name = \"a\", ct_mm = [0, 0, 50] }, { name = \"b\", ct_mm = [9, 0, 50] }, \
                          { name = \"c\", ct_mm = [0, 9, 50] }]";

    fn of(text: &str) -> Result<Scene, String> {
        Scene::parse(text, Path::new("folder/s.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn the_whole_way_is_read() {
        let text =
            format!("{LINKS}calibrate = \"base\"\ndrawing = \"base.toml\"\npoints = {THREE}\ncheck_points = {OTHERS}");
        let steps = of(&text).unwrap().steps.unwrap();
        assert_eq!(steps.calibrate, Some(Calibrating::Base));
        assert_eq!(steps.drawing.as_deref(), Some(Path::new("folder/base.toml")));
        assert!(matches!(&steps.register, Some(Registering::Points(points)) if points[1].name == "b"));
        assert_eq!((steps.check.len(), steps.turn_s, steps.touch_s), (3, 20.0, 1.0));
        let beads = of(&format!("{LINKS}beads = \"beads.json\"")).unwrap().steps.unwrap();
        assert_eq!(beads.register, Some(Registering::Beads("folder/beads.json".into())));
        assert!(of("").unwrap().steps.is_none());
    }

    #[test]
    fn what_cannot_be_done_is_refused_by_key() {
        let points = |text: &str| format!("{LINKS}points = {text}");
        for (text, said) in [
            (
                "[steps]\ncalibrate = \"pivot\"".to_owned(),
                "key steps: found a table; allowed: no such table unless",
            ),
            (
                LINKS.to_owned(),
                "key steps: found none of them; allowed: one of calibrate",
            ),
            (
                "[tracker]\nsource = \"operating-room\"\n[steps]\ncalibrate = \"pivot\"".to_owned(),
                "key steps.calibrate: found no such file; allowed: this key only with [tracker.calibration] file",
            ),
            (
                format!("[tracker]\nsource = \"operating-room\"\n[steps]\ncheck_points = {THREE}"),
                "key steps.check_points: found no such file; allowed: this key only with [tracker.registration]",
            ),
            (
                format!("{LINKS}calibrate = \"base\""),
                "key steps.drawing: found nothing",
            ),
            (
                format!("{LINKS}calibrate = \"pivot\"\ndrawing = \"d\""),
                "key steps.drawing: found folder/d; allowed: no drawing unless",
            ),
            (format!("{LINKS}calibrate = \"dance\""), "unknown variant `dance`"),
            (
                format!("{LINKS}beads = \"b\"\npoints = {THREE}"),
                "key steps.beads: found folder/b; allowed: either",
            ),
            (
                format!("{LINKS}points = {THREE}\ncheck_points = {THREE}"),
                "key steps.check_points.0.ct_mm: found 0.0 mm from \"a\" of steps.points; allowed: at least 5 mm",
            ),
            (points("[]"), "key steps.points: found 0; allowed: 3 to 32 points"),
            (
                points(&THREE.replace("\"b\"", "\"\"")),
                "key steps.points.1.name: found \"\"; allowed: 1 to 40 bytes",
            ),
            (points(&THREE.replace("\"b\"", "\"b,c\"")), "key steps.points.1.name"),
            (
                points(&THREE.replace("\"b\"", "\"a\"")),
                "key steps.points.1.name: found \"a\" a second time",
            ),
            (
                points(&THREE.replace("[9, 0, 0]", "[0, 4, 0]")),
                "key steps.points.1.ct_mm: found 4.0 mm from \"a\"; allowed: at least 5 mm",
            ),
            (
                points(&THREE.replace("[9, 0, 0]", "[nan, 4, 0]")),
                "key steps.points.1.ct_mm",
            ),
            (
                format!("{LINKS}calibrate = \"pivot\"\nturn_s = 0"),
                "key steps.turn_s: found 0; allowed: 2 to 120 s",
            ),
            (
                format!("{LINKS}calibrate = \"pivot\"\ntouch_s = nan"),
                "key steps.touch_s: found NaN; allowed: 0.3 to 10 s",
            ),
        ] {
            let found = of(&text).unwrap_err();
            assert!(found.contains(said), "{text}\n gave {found}\n not {said}");
        }
    }
}
