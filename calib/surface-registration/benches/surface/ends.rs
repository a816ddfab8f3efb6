//! Bones that the CT shows up to an open end, and points of which some lie beyond it.

use chance::Chance;
use geometry::{Ct, Point, Tracker};
use surface_registration::{
    Field, Limits, Options, Points, Priors, Spacing, Start, Surface, SurfaceRegistration, register,
};

use super::common::change::mirrored;
use super::common::draw::{ALL, Drawn, LEFT, PUBIS, RIGHT, Sweep, off, rms, targets, tre_mm};
use super::common::end::{Cut, End, about_axis, column, echoes_at_end, shaft, stretched};
use super::common::oracle::{self, Triangles};
use super::count::{Count, Truth};
use super::kinds::{Gates, Kind};
use super::run::seconds;

/// Which bone, and where it ends.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Bone {
    /// The pelvis without its pubis and lower wings.
    Wings,
    /// The pelvis without its upper wings.
    Lower,
    /// A hip alone, cut through its wing; and through its lower part.
    HipUp,
    HipDown,
    /// Hardly changes along itself.
    Shaft,
    /// Nearly comes back to itself.
    Column,
}

const BONES: [Bone; 6] = [
    Bone::Wings,
    Bone::Lower,
    Bone::HipUp,
    Bone::HipDown,
    Bone::Shaft,
    Bone::Column,
];

/// Without that which comes back to itself: a search that is told to look at the wrong level alone finds it there.
const UNLIKE: [Bone; 5] = [Bone::Wings, Bone::Lower, Bone::HipUp, Bone::HipDown, Bone::Shaft];

/// Without that which hardly changes along itself: of it a longer one is the same.
const UNEVEN: [Bone; 5] = [Bone::Wings, Bone::Lower, Bone::HipUp, Bone::HipDown, Bone::Column];

/// What is the matter beside.
#[derive(Clone, Copy, PartialEq)]
enum Matter {
    Nothing,
    Mirrored,
    /// Another one's bone: longer by shares along the axes.
    Other([f64; 3]),
    /// So many of the points within 15 mm of the end echo from what lies before the bone.
    EchoesAtEnd(f64),
}

struct Row {
    name: &'static str,
    bones: &'static [Bone],
    /// Points beyond the end, shares.
    share: [f64; 2],
    outliers: f64,
    points: usize,
    /// How far off the guess is along the end's axis, mm, and whether the search is told so.
    slide_mm: [f64; 2],
    is_told: bool,
    matter: Matter,
}

impl Row {
    fn kind(&self, bone: Bone) -> Kind {
        // why: a search told to look within 8 mm of a guess that is further off, a mirrored bone and somebody else's are not what was told.
        if !self.is_told || matches!(self.matter, Matter::Mirrored | Matter::Other(_)) {
            return Kind::Broken;
        }
        // why: levels of the column are alike to 0.3 mm, less than a point's own error along its beam (0.5 mm).
        if bone == Bone::Column { Kind::Weak } else { Kind::Holds }
    }
}

const ROW: Row = Row {
    name: "",
    bones: &BONES,
    share: [0.05, 0.35],
    outliers: 0.1,
    points: 200,
    slide_mm: [0.0, 0.0],
    is_told: true,
    matter: Matter::Nothing,
};

fn rows() -> Vec<Row> {
    let long = Matter::Other([1.0, 1.0, 1.08]);
    let thick = Matter::Other([1.06, 0.95, 1.0]);
    vec![
        Row {
            name: "end: 10 %",
            ..ROW
        },
        Row {
            name: "end: 30 %",
            outliers: 0.3,
            ..ROW
        },
        Row {
            name: "end: 40 %, guess over it",
            outliers: 0.4,
            slide_mm: [10.0, 30.0],
            ..ROW
        },
        Row {
            name: "end: all known, guess over it",
            share: [0.0, 0.0],
            slide_mm: [10.0, 40.0],
            ..ROW
        },
        Row {
            name: "end: guess over it, not told",
            bones: &UNLIKE,
            share: [0.0, 0.2],
            slide_mm: [15.0, 40.0],
            is_told: false,
            ..ROW
        },
        Row {
            name: "end: guess before it, not told",
            bones: &UNLIKE,
            slide_mm: [-40.0, -15.0],
            is_told: false,
            ..ROW
        },
        Row {
            name: "end: echoes at it",
            share: [0.0, 0.2],
            slide_mm: [0.0, 20.0],
            matter: Matter::EchoesAtEnd(0.8),
            ..ROW
        },
        Row {
            name: "end: longer bone",
            bones: &UNEVEN,
            slide_mm: [0.0, 20.0],
            matter: long,
            ..ROW
        },
        Row {
            name: "end: thicker bone",
            slide_mm: [0.0, 20.0],
            matter: thick,
            ..ROW
        },
        Row {
            name: "end: mirrored",
            slide_mm: [0.0, 20.0],
            matter: Matter::Mirrored,
            ..ROW
        },
        Row {
            name: "end: 40 points",
            points: 40,
            ..ROW
        },
        Row {
            name: "end: 60 points, guess over it, 30 %",
            points: 60,
            outliers: 0.3,
            slide_mm: [10.0, 30.0],
            ..ROW
        },
    ]
}

struct Scene {
    bone: Bone,
    cut: Cut,
    surface: Surface<Ct>,
    field: Field,
}

fn scene(bone: Bone, pelvis: &Triangles, hip: &Triangles) -> Scene {
    let z = |at_mm: f64, up: f64| End {
        axis: [0.0, 0.0, up],
        at_mm: at_mm * up,
    };
    let crests = LEFT | RIGHT | PUBIS;
    let middle = |t: &Triangles| {
        let n = t.0.len() as f64;
        [0, 1, 2].map(|k| t.0.iter().map(|p| p[k]).sum::<f64>() / n)
    };
    let hips = || {
        let [x, y, z] = middle(hip);
        [[20.0, 0.0, 0.0], [-20.0, 10.0, 20.0], [0.0, -15.0, -30.0]]
            .map(|[a, b, c]| geometry::Point::new(x + a, y + b, z + c))
            .to_vec()
    };
    let hip_z = middle(hip)[2];
    let cut = match bone {
        Bone::Wings => Cut::new(pelvis, z(120.0, 1.0), crests, [90.0, 40.0], targets().to_vec()),
        Bone::Lower => Cut::new(pelvis, z(90.0, -1.0), crests, [130.0, 40.0], targets().to_vec()),
        Bone::HipUp => Cut::new(hip, z(hip_z + 30.0, 1.0), ALL, [60.0, 30.0], hips()),
        Bone::HipDown => Cut::new(hip, z(hip_z - 20.0, -1.0), ALL, [60.0, 30.0], hips()),
        Bone::Shaft => Cut::new(&shaft(), z(40.0, 1.0), ALL, [110.0, 30.0], about_axis()),
        Bone::Column => Cut::new(&column(), z(40.0, 1.0), ALL, [110.0, 40.0], about_axis()),
    };
    let surface = Surface::<Ct>::new(&cut.shown.0, &cut.shown.1).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    Scene {
        bone,
        cut,
        surface,
        field,
    }
}

fn drawn(scene: &Scene, row: &Row, seed: u64) -> Drawn {
    let c = Chance::new(seed, 1 << 48);
    let sweep = Sweep {
        regions: ALL,
        points: row.points,
        outliers: row.outliers,
        ..Sweep::default()
    };
    let share = row.share[0] + (row.share[1] - row.share[0]) * c.uniform(0);
    let mut drawn = scene.cut.draw(&sweep, share, seed);
    match row.matter {
        Matter::Nothing => {}
        Matter::Mirrored => drawn = mirrored(drawn),
        Matter::Other(by) => stretched(&mut drawn, by),
        Matter::EchoesAtEnd(share) => echoes_at_end(&mut drawn, &scene.cut.end, [15.0, 40.0], share, seed),
    }
    drawn
}

fn found(scene: &Scene, row: &Row, drawn: &Drawn, seed: u64) -> Option<SurfaceRegistration<Ct, Tracker>> {
    let c = Chance::new(seed, 1 << 48);
    let slide = row.slide_mm[0] + (row.slide_mm[1] - row.slide_mm[0]) * c.uniform(1);
    let points = Points::new(&drawn.points, None, 0.5).ok()?;
    let start = Start::Guess {
        pose: off(&scene.cut.slid(drawn, slide), 5.0, 5.0, seed),
        turn_rad: 0.15,
        shift_mm: if row.is_told { 8.0 + slide.abs() } else { 8.0 },
    };
    let mut options = Options::default();
    options.priors.bone_mm = 0.0;
    register(&scene.surface, &scene.field, &points, &start, &options).ok()
}

/// Runs the rows whose names have all these words, and adds them to `all`.
pub(crate) fn ends(runs: u64, first_seed: u64, words: &[&String], (all, gates): (&mut Count, &mut Gates)) {
    let chosen: Vec<Row> = rows()
        .into_iter()
        .filter(|row| words.iter().all(|word| row.name.contains(word.as_str())))
        .collect();
    let (Some(pelvis), Some(hip)) = (oracle::bone("pelvis-phantom"), oracle::bone("hip77")) else {
        return;
    };
    if chosen.is_empty() {
        return;
    }
    let scenes = BONES.map(|bone| scene(bone, &pelvis, &hip));
    println!("| row | right | wrong | silent | right refused | beyond | TRE mm: rms, predicted | 95 % | chi2/3 | ms |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for row in &chosen {
        let mut count = Count::default();
        let (mut beyond, mut squares) = (0.0, [0.0, 0.0]);
        for run in 0..runs {
            let seed = first_seed + run;
            let scene = scenes
                .iter()
                .find(|s| s.bone == row.bones[run as usize % row.bones.len()])
                .unwrap();
            let drawn = drawn(scene, row, seed);
            let (time, found) = seconds(|| found(scene, row, &drawn, seed));
            count.runs += 1;
            count.seconds += time;
            let Some(found) = found else {
                count.failed += 1;
                continue;
            };
            let targets = &scene.cut.targets;
            let tre = rms(&tre_mm(&found.transform.transform(), &drawn.ct_from_tracker, targets));
            let refusals = Limits::default().judge(&found, targets);
            let truly = drawn
                .exact
                .iter()
                .filter(|p| scene.cut.end.beyond_mm(&p.mm().into()) > 0.0);
            let name = format!("{} {:?}, {} truly beyond,", row.name, scene.bone, truly.count());
            let is_beyond = |p: &Point<Ct>| scene.cut.end.beyond_mm(&p.mm().into()) > 0.0;
            let priors = Priors {
                bone_mm: 0.0,
                ..Priors::default()
            };
            let kind = row.kind(scene.bone);
            let truth = Truth {
                tre,
                kind: kind.of_run(&scene.surface, &drawn, is_beyond, targets, &priors),
                drawn: &drawn,
                targets,
            };
            count.judged(&name, seed, &truth, &found, &refusals);
            beyond += found.share_beyond / runs as f64;
            if refusals.is_empty() {
                let predicted: Vec<f64> = targets.iter().map(|t| found.predicted_tre_mm(*t)).collect();
                squares[0] += tre * tre;
                squares[1] += rms(&predicted).powi(2);
            }
        }
        let taken = (count.runs - count.failed - count.stopped).max(1) as f64;
        println!(
            "{}",
            count.line_of_end(row.name, beyond, squares.map(|s| (s / taken).sqrt()))
        );
        all.add(&count);
        gates.row(row.name, &count.kinds);
    }
}
