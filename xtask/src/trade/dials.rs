//! The dials: what each is for, where it is turned, and which benchmark measures it.

/// Calls of `cargo bench`, as few as may be: each builds what several packages share for itself. By itself stands what has the name of
/// another package's benchmark.
pub(super) const BENCHES: [(&[&str], &[&str]); 2] = [
    (
        &[
            "slice-view-proc",
            "calib",
            "bead",
            "bus",
            "tracker-proc",
            "simulation",
            "tissue-proc",
        ],
        &[
            "trade",
            "warp",
            "registration",
            "pose",
            "pivot",
            "bundle",
            "base",
            "bead",
            "clock_map",
            "chain",
            "solids_trade",
            "strokes",
        ],
    ),
    (&["surface-registration"], &["surface"]),
];

/// Headings of the page, and panels of the picture.
pub(super) const GROUPS: [&str; 8] = [
    "Images",
    "Poses of markers",
    "Late poses",
    "A device's clock",
    "Calibration",
    "Beads and bone",
    "Solids",
    "Tissue of a run",
];

/// Where a dial is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Key {
    /// A key of the scene file: table and name.
    Scene(&'static str),
    /// An option of a command, after its words.
    Option(&'static str),
    /// A word of a scene of solids, or of organs: the file, and the word.
    File(&'static str, &'static str),
    /// Not to be turned but in the code: the file, and the word.
    Code(&'static str, &'static str),
}

/// A dial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dial {
    /// As benchmarks call it.
    pub(super) name: &'static str,
    /// Of [`GROUPS`].
    pub(super) group: usize,
    pub(super) title: &'static str,
    pub(super) key: Key,
    /// What it is for, and when to turn it.
    pub(super) what: &'static str,
    /// Whether its settings go from less to more, and are not a choice of several ways.
    pub(super) is_scale: bool,
}

const fn dial(name: &'static str, group: usize, title: &'static str, key: Key, what: &'static str) -> Dial {
    Dial {
        name,
        group,
        title,
        key,
        what,
        is_scale: true,
    }
}

const fn choice(name: &'static str, group: usize, title: &'static str, key: Key, what: &'static str) -> Dial {
    Dial {
        is_scale: false,
        ..dial(name, group, title, key, what)
    }
}

const KIDNEY: &str = "config/solids/demo-kidney.toml";
const RING: &str = "config/solids/figure-37.toml";

/// All of them, in the order of the page.
pub(super) const DIALS: [Dial; 31] = [
    choice(
        "filter",
        0,
        "Filter, smooth tissue",
        Key::Scene("views.filter"),
        "How voxels are interpolated. Turn it up where small bright things are looked at on pixels smaller than voxels.",
    ),
    choice(
        "filter-at-edges",
        0,
        "Filter, sharp edges",
        Key::Scene("views.filter"),
        "The same filters where edges are sharper than voxels: there the long ones gain nothing over `b-spline`.",
    ),
    choice(
        "back-end",
        0,
        "Back end",
        Key::Scene("render.back_end"),
        "Who draws: the processor (`cpu`; `cpu-portable` without its vector instructions), or a card where there is one, whose time is the \
         clock's. `reference` is the plain code that all are tested by, and draws snapshots only.",
    ),
    dial(
        "slab",
        0,
        "Slab",
        Key::Scene("views.slab"),
        "A thick slice has less noise and less sharpness. Turn it up for low doses and large soft things, not for small targets.",
    ),
    dial(
        "spacing",
        0,
        "Distance between voxels",
        Key::Scene("volume.spacing_mm"),
        "Of the generated patient; of a CT of your own `volume.downsample` makes voxels larger. Time changes little: turn it for memory.",
    ),
    dial(
        "emitters",
        1,
        "Emitters of a marker",
        Key::Option("calib marker --emitters"),
        "More emitters average more noise. A marker's number is chosen when it is built; fewer seen is what hands and drapes do.",
    ),
    choice(
        "weights",
        1,
        "Weights of emitters",
        Key::Code("calib/src/pose/localizer.rs", "depth_mm"),
        "Full weights know that a localizer is worse along its line of sight (`tracker.emitters.localizer`); the closed solution has neither \
         covariance nor gates. There is no reason to turn it down but to see what it is worth.",
    ),
    dial(
        "smoothing",
        2,
        "Smoothing",
        Key::Scene("tracker.smoothing.time_constant_ms"),
        "Less trembling for more lag. Time is how late the shown pose is. Turn it up for a localizer with much noise and a hand that is nearly \
         still; what moves is shown where it was.",
    ),
    dial(
        "rate",
        2,
        "Poses a second",
        Key::Scene("tracker.rate_hz"),
        "Half the time between poses is how late what is shown is in the mean, before any delay of the localizer and of images. What lag costs a \
         hand is told in [a hand in silico](hand.md).",
    ),
    choice(
        "clock",
        3,
        "A capture's time",
        Key::Code("crates/scene/src/localizer.rs", "Mapped"),
        "What a frame's capture is taken for (`clock` in the table of the [localizer](localizer.md)): its stamp by the law of the device's clock, or \
         its arrival. The two below are what other software does. At 100 mm/s 10 ms are 1 mm.",
    ),
    choice(
        "registration-method",
        4,
        "Registration of pairs",
        Key::Option("calib register --method"),
        "All methods find the same optimum; they differ in digits where points lie nearly in a line, as here, far below what any registration notices. There is no need to turn it.",
    ),
    choice(
        "pivot-method",
        4,
        "Pivot calibration, method",
        Key::Option("calib pivot --method"),
        "Turn it down only for poses without any slip and of even noise: the quicker ones count every pose alike.",
    ),
    dial(
        "pivot-turning",
        4,
        "Pivot calibration, seconds of turning",
        Key::Scene("steps.turn_s"),
        "The person's time is the setting; the computer's is beside it. The error falls with the root of the seconds.",
    ),
    dial(
        "marker-views",
        4,
        "Views of a marker",
        Key::Option("calib marker --min-views"),
        "How many frames a marker is turned before the localizer for; the bold one is no default. Turn it up until the predicted error of its \
         emitters is below what the tip can bear.",
    ),
    dial(
        "base-touches",
        4,
        "Touches of the calibration base",
        Key::Option("calib base --min-touches"),
        "Touches of the plate and of each of three grooves; the bold one is no default. The person's time, not the computer's.",
    ),
    choice(
        "bead-ground",
        5,
        "What lies around a bead",
        Key::Code("calib/bead/src/search.rs", "ground"),
        "What the tissue under a bead is taken for. In this drawn body, whose bone is even, a constant does best; in real CTs the random field does, by 1.3 to 8 \
         times ([beads](beads.md)), so there is no key.",
    ),
    dial(
        "bead-radius",
        5,
        "How well beads' radii are known",
        Key::Option("calib beads --radius-range-mm"),
        "Radii that are looked for. A wider range takes longer; say the radius where it is known.",
    ),
    dial(
        "surface-points",
        5,
        "Points of a bone's surface",
        Key::Option("calib surface --points"),
        "How many points are touched or swept. The person's time: turn it up where the target is far from what can be touched.",
    ),
    dial(
        "surface-fitted",
        5,
        "Seeds of the surface's search that are fitted",
        Key::Code("calib/surface-registration/src/search.rs", "tried"),
        "The best of 20 000 starts, from a guess 60 degrees and 50 mm off: with too few the right one is not among them.",
    ),
    dial(
        "surface-lattice",
        5,
        "Lattice of distances to the surface",
        Key::Code("calib/surface-registration/src/field.rs", "spacing_mm"),
        "How finely distances are tabled for the search, which the surface itself has the last word after; the table is made once, and its \
         time is not in it.",
    ),
    dial(
        "plane-mesh",
        6,
        "In the plane: elements of a ring",
        Key::File(RING, "elements"),
        "Nine-node elements round and through it. The first dial to turn for a shape, the last for a picture.",
    ),
    dial(
        "plane-barrier",
        6,
        "In the plane: width of the barrier",
        Key::File(RING, "widths"),
        "How far off solids push one another. `simulate run` ends in exact contact, which costs less than narrow barriers.",
    ),
    dial(
        "plane-tolerance",
        6,
        "In the plane: tolerance of forces",
        Key::Code("crates/simulation/src/control/settings.rs", "tolerance"),
        "When forces balance. Newton's last steps gain many digits each; stopping early saves them.",
    ),
    dial(
        "space-cube",
        6,
        "In space: side of cubes",
        Key::File(KIDNEY, "side"),
        "Of a ball of 40 mm with a hole of 20 mm. The dial of a mesh: an eighth of the unknowns at twice the side.",
    ),
    choice(
        "space-element",
        6,
        "In space: element",
        Key::Code("crates/simulation/src/space/cells/settings.rs", "order"),
        "Cubes of 27 nodes beside those of 8, which need to be so much smaller that they cost more for the same error.",
    ),
    dial(
        "tissue-cube",
        7,
        "Side of an organ's cubes",
        Key::File(KIDNEY, "side"),
        "Of the largest cubes; near the tube's way they are half as large. The row of the least side says how far the finest cubes, which others are \
         held against, can be trusted.",
    ),
    dial(
        "tissue-tolerance",
        7,
        "Tolerance of a state",
        Key::Scene("tissue.tolerance"),
        "Free forces over those of contact at which a state is settled. Turn it up where states are late.",
    ),
    dial(
        "tissue-refresh",
        7,
        "Refresh of second derivatives",
        Key::Scene("tissue.refresh_mm"),
        "How far the tube goes on old ones: more often costs factors, less often steps. The median hardly shows either.",
    ),
    dial(
        "tissue-delay",
        7,
        "Delay of factors",
        Key::Scene("tissue.delay"),
        "States later that another thread's factors are taken up; with 0 the frame's own thread makes them. The median does not show that: it is the few frames \
         with new factors that take longer.",
    ),
    dial(
        "tissue-steps",
        7,
        "Steps for a pose",
        Key::Scene("tissue.most_steps"),
        "Where they do not suffice the image says NOT SETTLED. Turn it down for an even time, up where that is often said.",
    ),
    dial(
        "tissue-piece",
        7,
        "Pieces of organs in images",
        Key::Scene("tissue.piece_mm"),
        "Organs are cut into pieces of at most this size, in which the motion is straight. What small pieces leave over is the error of the cubes of 10 mm that \
         they are cut from, not theirs.",
    ),
];
