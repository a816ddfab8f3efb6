//! Lines of bone in the images of a tracked probe, as points of the file of a sweep.

use geometry::{Direction, Image, Marker, Point, Rigid, Tracker, Uncertain, UncertainPoint, checked};
use nalgebra::{Matrix3, Vector3};
use probe::Track;

use super::super::calibrated::Calibrated;
use super::super::error::SurfaceCommandError;
use super::taken::{Refused, Taken};
use crate::live::{Listened, Looked, touches_comment};

/// Between two poses that are further apart in time nothing is known of the way, s.
const GAP_S: f64 = 0.15;
/// By so much the error of the lag may move a point, deviation, mm: it moves neighbours alike, which is not reckoned with.
const MOST_LATE_MM: f64 = 0.2;
/// Points that a file has at most.
const MOST_ROWS: usize = 10_000;

/// How late the first images of a sweep came is told by so many of them, and of the others by as many: single ones may be late.
const TOGETHER: usize = 9;
/// The least of that may differ by this: at 10 mm/s a point is off by 0.2 mm, ns.
const MOST_OTHER_NS: i64 = 20_000_000;

/// How images become points.
pub(in super::super) struct Sounding<'a> {
    pub(in super::super) probe: &'a Calibrated,
    /// A point each so far along a line, mm.
    pub(in super::super) step_mm: f64,
    /// Deviation of a point across its image, mm.
    pub(in super::super) elevation_mm: f64,
}

/// As many as a registration takes.
fn thinned(rows: Vec<Row>) -> Vec<Row> {
    let every = rows.len().div_ceil(MOST_ROWS).max(1);
    rows.into_iter().step_by(every).collect()
}

/// Counts an image that was refused.
fn refuse(refused: &mut Option<Refused>, seq: u64, why: SurfaceCommandError, of: usize) {
    let refused = refused.get_or_insert(Refused {
        count: 0,
        of,
        last: seq,
        first: why,
    });
    refused.count += 1;
    refused.last = seq;
}

/// A point with its errors.
struct Row {
    seq: u64,
    pose: Rigid<Tracker, Marker>,
    seen: UncertainPoint<Tracker>,
    beam: Direction<Tracker>,
    depth_mm: f64,
}

impl Sounding<'_> {
    /// The points of all images so far, as a file.
    pub(in super::super) fn csv(&self, heard: &Listened, tool: &str, frame: &str) -> Taken {
        let (rows, refused) = self.rows(heard);
        Taken {
            text: self.text(&rows, tool, frame),
            count: rows.len(),
            refused,
        }
    }

    /// The same of images each of which has a pose of its own, as the frames of a recording have; nothing is late there.
    pub(in super::super) fn csv_of_own(
        &self,
        frames: &[(Looked, Uncertain<Tracker, Marker>)],
        tool: &str,
        frame: &str,
    ) -> Taken {
        let mut rows = Vec::new();
        for (image, pose) in frames {
            let posed = Posed {
                pose: *pose,
                between: [pose.transform(); 2],
                passed_s: 1.0,
            };
            self.points(image, &posed, &mut rows);
        }
        let rows = thinned(rows);
        Taken {
            text: self.text(&rows, tool, frame),
            count: rows.len(),
            refused: None,
        }
    }

    fn text(&self, rows: &[Row], tool: &str, frame: &str) -> String {
        let mut text = format!(
            "{}\n{}\non,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,beam_x,beam_y,beam_z,depth,marker_qw,marker_qx,marker_qy,marker_qz,marker_x,marker_y,marker_z\n",
            touches_comment(tool, frame, &self.probe.marker_from_image),
            self.probe.comment()
        );
        for row in rows {
            let c = row.seen.covariance();
            let covariance = [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]];
            let (q, t) = (row.pose.quaternion(), row.pose.translation_mm());
            let beam = row.beam.components();
            let numbers = [&row.seen.point().mm()[..], &covariance, &beam, &[row.depth_mm], &q, &t].concat();
            let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
            text += &format!("image {},{}\n", row.seq, words.join(","));
        }
        text
    }

    fn rows(&self, heard: &Listened) -> (Vec<Row>, Option<Refused>) {
        let mut timed: Vec<(f64, Rigid<Tracker, Marker>)> = Vec::with_capacity(heard.poses.len());
        for (t_s, pose) in heard.times_s.iter().zip(&heard.poses) {
            // A frame that came late is passed over.
            if timed.last().is_none_or(|(last_s, _)| t_s > last_s) {
                timed.push((*t_s, pose.transform()));
            }
        }
        let Ok(track) = Track::new(&timed, 0.0) else {
            return (Vec::new(), None);
        };
        let (mut rows, mut refused) = (Vec::new(), None);
        let mut first = None;
        let steady = steady(&heard.images);
        for (image, steady) in heard.images.iter().zip(steady) {
            if let Err(why) = self.check(image, first.unwrap_or(image)).and(steady) {
                refuse(&mut refused, image.seq, why, heard.images.len());
                continue;
            }
            first = first.or(Some(image));
            let t_s = heard.seconds_of(image.t_capture_ns) + self.probe.lag_s[0];
            if let Some(posed) = posed(heard, &track, t_s) {
                self.points(image, &posed, &mut rows);
            }
        }
        (thinned(rows), refused)
    }

    /// Refuses an image that the calibration does not hold for; `first` is the first of the sweep that it holds for.
    fn check(&self, image: &Looked, first: &Looked) -> Result<(), SurfaceCommandError> {
        let seq = image.seq;
        let shape = image
            .shape
            .as_ref()
            .map_err(|why| SurfaceCommandError::NoShape { seq, why: why.clone() })?;
        self.probe.holds_for(seq, shape)?;
        self.probe.is_turned_alike(seq, image.orientation.as_deref())?;
        if image.shape != first.shape {
            return Err(SurfaceCommandError::OtherShape { seq });
        }
        match image.is_stamped {
            true => Ok(()),
            false => Err(SurfaceCommandError::NotStamped { seq }),
        }
    }

    /// The points of one image.
    fn points(&self, image: &Looked, posed: &Posed, rows: &mut Vec<Row>) {
        let Ok(line) = &image.line else { return };
        let marker_from_image = self.probe.marker_from_image.transform();
        let on_marker = posed.pose * marker_from_image;
        let mut last: Option<[f64; 2]> = None;
        for point in &line.points {
            let [x, y] = [0, 1].map(|i| point.pixel[i] * self.probe.pixel_mm[i]);
            if last.is_some_and(|[a, b]| (a - x).hypot(b - y) < self.step_mm) {
                continue;
            }
            last = Some([x, y]);
            // The lag's own error moves a point along its way, and many of them alike: where that is much, none is taken.
            let late_mm = self.probe.lag_s[1] * posed.speed_mm_s(marker_from_image * Point::new(x, y, 0.0));
            if late_mm > MOST_LATE_MM {
                continue;
            }
            let late = Matrix3::identity() * (late_mm * late_mm);
            let [along_x, along_y] = point.beam.direction;
            let axis = |x: f64, y: f64, z: f64, mm: f64| {
                let axis = Vector3::new(x, y, z);
                axis * axis.transpose() * (mm * mm)
            };
            let own = axis(along_x, along_y, 0.0, point.axial_mm)
                + axis(-along_y, along_x, 0.0, point.lateral_mm)
                + axis(0.0, 0.0, 1.0, self.elevation_mm)
                + late;
            let (Ok(seen), Ok(beam)) = (
                UncertainPoint::<Image>::new(Point::new(x, y, 0.0), own),
                checked::direction::<Image>([along_x, along_y, 0.0]),
            ) else {
                continue;
            };
            rows.push(Row {
                seq: image.seq,
                pose: posed.pose.transform(),
                seen: on_marker * seen,
                beam: on_marker.transform() * beam,
                depth_mm: point.beam.depth_mm,
            });
        }
    }
}

/// Whether each image kept to the clock that the first ones of the sweep had, against that of the poses. A lag that was found before holds for a
/// constant offset alone, and by hindsight also a step is seen that was not yet known when its first images came.
fn steady(images: &[Looked]) -> Vec<Result<(), SurfaceCommandError>> {
    let stamped: Vec<&Looked> = images.iter().filter(|image| image.is_stamped).collect();
    let least = |from: usize| stamped[from..].iter().take(TOGETHER).map(|image| image.late_ns).min();
    let first_ns = least(0).unwrap_or(0);
    let mut next = 0;
    images
        .iter()
        .map(|image| {
            // What is not stamped is refused as that.
            let by_ns = if image.is_stamped {
                least(next).unwrap_or(0).saturating_sub(first_ns)
            } else {
                0
            };
            next += usize::from(image.is_stamped);
            match by_ns.saturating_abs() <= MOST_OTHER_NS {
                true => Ok(()),
                false => Err(SurfaceCommandError::OtherLateness {
                    seq: image.seq,
                    by_ms: bus::clock::ms(by_ns),
                }),
            }
        })
        .collect()
}

/// The marker at the time of an image.
struct Posed {
    pose: Uncertain<Tracker, Marker>,
    /// The poses before and after, and from one to the other, s.
    between: [Rigid<Tracker, Marker>; 2],
    passed_s: f64,
}

impl Posed {
    /// How fast a place on the marker moves, mm/s.
    fn speed_mm_s(&self, place: Point<Marker>) -> f64 {
        let [from, to] = self.between;
        (from * place).distance(to * place) / self.passed_s
    }
}

/// The marker at a time, between two poses that are near.
fn posed(heard: &Listened, track: &Track<Tracker, Marker>, t_s: f64) -> Option<Posed> {
    let after = heard.times_s.partition_point(|t| *t < t_s);
    let before = after.checked_sub(1)?;
    let (from, to) = (heard.poses.get(before)?, heard.poses.get(after)?);
    let passed_s = heard.times_s[after] - heard.times_s[before];
    if !(passed_s > 0.0 && passed_s <= GAP_S) {
        return None;
    }
    Some(Posed {
        pose: Uncertain::from_upper(track.at(t_s)?, to.upper()).ok()?,
        between: [from.transform(), to.transform()],
        passed_s,
    })
}

/// How many images came, in how many bone was found, and why not in the last one.
pub(super) fn sounded_words(heard: &Listened) -> String {
    let with_bone = heard.images.iter().filter(|image| image.line.is_ok()).count();
    let last = heard.images.last().and_then(|image| image.line.as_ref().err());
    let why = last.map_or_else(String::new, |why| format!("; the last without: {why}"));
    format!("bone in {with_bone} of {} images{why}", heard.images.len())
}

#[cfg(test)]
mod tests {
    use super::super::super::calibrated::tests::calibrated;
    use super::*;
    use crate::commands::probe::ImagesRecord;
    use echo::bone::{BoneLine, BonePoint};
    use geometry::Vector;
    use ultrasound::{Beam, Beams, Shape};

    fn looked(depth_mm: f64, pixel_mm: f64) -> Looked {
        let beams = Beams::Linear {
            from_mm: 0.0,
            to_mm: 20.0,
            face_mm: 0.0,
        };
        Looked {
            t_capture_ns: 0,
            seq: 7,
            shape: Ok(Shape::new([200, 300], [pixel_mm; 2], beams, depth_mm).unwrap()),
            orientation: None,
            is_stamped: true,
            late_ns: 60_000_000,
            line: Err("nothing".to_owned()),
        }
    }

    /// An image whose source says no pixels was once told to be of another depth, and one stamped by its arrival was taken.
    #[test]
    fn images_that_the_calibration_does_not_hold_for_are_refused_by_name() {
        let probe = calibrated(ImagesRecord::default());
        let sounding = Sounding {
            probe: &probe,
            step_mm: 2.0,
            elevation_mm: 0.7,
        };
        let first = looked(30.0, 0.1);
        let words = |image: &Looked| sounding.check(image, &first).unwrap_err().to_string();
        assert!(sounding.check(&first, &first).is_ok());
        assert!(words(&looked(30.0, 0.103)).contains("the depth was changed"));
        assert!(words(&looked(25.0, 0.1)).contains("another size, depth or array than the first"));
        let unstamped = Looked {
            is_stamped: false,
            ..looked(30.0, 0.1)
        };
        assert!(words(&unstamped).contains("stamped by its arrival"));
        let turned = calibrated(ImagesRecord {
            orientation: Some("MF".to_owned()),
            ..ImagesRecord::default()
        });
        let turned = Sounding {
            probe: &turned,
            ..sounding
        };
        let mirrored = Looked {
            orientation: Some("UF".to_owned()),
            ..looked(30.0, 0.1)
        };
        let found = turned.check(&mirrored, &first).unwrap_err().to_string();
        assert!(
            found.contains("image 7 is turned UF") && found.contains("MF"),
            "{found}"
        );
        assert!(sounding.check(&mirrored, &first).is_ok() && turned.check(&first, &first).is_ok());
        let unknown = Looked {
            shape: Err("its source does not say".to_owned()),
            ..looked(30.0, 0.1)
        };
        assert_eq!(words(&unknown), "image 7: its source does not say");
    }

    /// The speed is the point's, and not that of the marker, about which the probe may turn.
    #[test]
    fn a_probe_that_turns_about_its_marker_moves_what_it_sees() {
        let turned = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.01), Vector::new(0.0, 0.0, 0.0)).unwrap();
        let posed = Posed {
            pose: Uncertain::from_upper(Rigid::identity(), [0.0; 21]).unwrap(),
            between: [Rigid::identity(), turned],
            passed_s: 0.02,
        };
        assert_eq!(posed.speed_mm_s(Point::new(0.0, 0.0, 0.0)), 0.0);
        // A chord of 0.01 rad at 150 mm.
        let expected = 2.0 * 150.0 * 0.005_f64.sin() / 0.02;
        assert!((posed.speed_mm_s(Point::new(150.0, 0.0, 0.0)) - expected).abs() < 1e-9);
    }

    /// A line of three points 15 mm deep, 5 mm apart.
    fn line() -> BoneLine {
        let point = |x: f64| BonePoint {
            pixel: [x / 0.1, 150.0],
            place_mm: [x, 15.0],
            beam: Beam {
                direction: [0.0, 1.0],
                depth_mm: 15.0,
                share: x / 20.0,
            },
            axial_mm: 0.1,
            lateral_mm: 0.5,
            echo_mm: 0.2,
            slope: 0.0,
            contrast: 50.0,
            ridge: 0,
        };
        BoneLine {
            points: [5.0, 10.0, 15.0].map(point).to_vec(),
            ridges: Vec::new(),
            shadow_share: 1.0,
            margin: 1.0,
        }
    }

    /// One image of another depth at the end once lost all points of the sweep.
    #[test]
    fn a_bad_image_at_the_end_is_named_and_the_points_of_the_others_are_kept() {
        let probe = calibrated(ImagesRecord::default());
        let sounding = Sounding {
            probe: &probe,
            step_mm: 2.0,
            elevation_mm: 0.7,
        };
        let times_s: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.05).collect();
        let poses = vec![Uncertain::from_upper(Rigid::identity(), [0.0; 21]).unwrap(); 60];
        let images = |bad: &[u64]| -> Vec<Looked> {
            let one = |seq: u64| Looked {
                seq,
                t_capture_ns: 100_000_000 * (seq as i64 + 1),
                line: Ok(line()),
                ..looked(30.0, if bad.contains(&seq) { 0.13 } else { 0.1 })
            };
            (0..20).map(one).collect()
        };
        let taken = |bad: &[u64]| {
            let heard = Listened::recorded(poses.clone(), times_s.clone(), images(bad));
            sounding.csv(&heard, "probe", "tracker")
        };
        let all = taken(&[]);
        assert!(all.refused.is_none() && all.count == 60, "{}", all.count);
        let kept = taken(&[19]);
        let refused = kept.refused.unwrap();
        assert_eq!((kept.count, refused.count, refused.is_most()), (57, 1, false));
        let words = refused.to_string();
        assert!(
            words.contains("1 of 20 images are left out") && words.contains("image 19 has pixels of 0.13 x 0.13 mm"),
            "{words}"
        );
        assert_eq!(kept.text, all.text.split("image 19").next().unwrap());
        // The first one is bad: the others are not measured by it.
        assert_eq!(taken(&[0]).count, 57);
        // And where most are, the sweep is none.
        let most: Vec<u64> = (5..20).collect();
        let few = taken(&most);
        assert!(few.count == 15 && few.refused.unwrap().is_most());
    }

    /// A clock that was set in a sweep gave images of both sides of the step, of which one lag cannot be true.
    #[test]
    fn images_after_a_step_of_their_clock_are_left_out_from_the_first_on_and_late_ones_are_not() {
        const MS: i64 = 1_000_000;
        let at = |set_ms: i64, is_late: fn(usize) -> bool| -> Vec<bool> {
            let one = |k: usize| Looked {
                seq: k as u64,
                late_ns: (60 + if k >= 40 { set_ms } else { 0 } + if is_late(k) { 90 } else { 0 }) * MS,
                ..looked(30.0, 0.1)
            };
            let images: Vec<Looked> = (0..100).map(one).collect();
            steady(&images).iter().map(Result::is_ok).collect()
        };
        let never: fn(usize) -> bool = |_| false;
        for set_ms in [-21, 21, 300] {
            let kept = at(set_ms, never);
            // Of images that came earlier the eight before are not told apart from those.
            let from = if set_ms < 0 { 32 } else { 40 };
            assert!(
                kept[..from].iter().all(|kept| *kept) && !kept[from..].contains(&true),
                "{set_ms}"
            );
        }
        assert!(!at(-20, never).contains(&false) && !at(20, never).contains(&false));
        assert!(!at(0, |k| k % 9 != 0).contains(&false), "a network that is busy");
        assert_eq!(
            at(0, |k| k == 99).iter().filter(|kept| !**kept).count(),
            1,
            "nothing vouches for the last"
        );
        // A step that the localizer found, and what it does not know in between.
        let mut images = vec![looked(30.0, 0.1); 40];
        images[20..30].iter_mut().for_each(|image| image.is_stamped = false);
        images[30..].iter_mut().for_each(|image| image.late_ns = 100 * MS);
        let words: Vec<String> = steady(&images)
            .iter()
            .filter_map(|one| one.as_ref().err().map(ToString::to_string))
            .collect();
        assert_eq!(words.len(), 10);
        assert!(
            words[0].contains("came 40 ms later") && words[0].contains("the clock of the images was set"),
            "{words:?}"
        );
    }
}
