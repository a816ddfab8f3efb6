//! A bone that is no figure of revolution, and points of it in a tracker's frame.

use chance::Chance;
use exchange::PatientAxes;
use exchange::mesh::{Mesh, MeshFormat, write};
use geometry::{Ct, Point, Rigid, Tracker, Vector};

/// Deviation of the points along each axis, mm.
pub(in crate::surface) const NOISE_MM: f64 = 0.3;
/// Cuts of an octahedron's edge.
const CUTS: u32 = 40;

pub(super) struct Planted {
    pub(super) ct_from_tracker: Rigid<Ct, Tracker>,
    mesh: Mesh,
    /// In the CT, with their errors.
    points: Vec<[f64; 3]>,
}

/// The bone's radius in a direction, mm: a ball with bumps that no turn and no mirror brings back.
pub(in crate::surface) fn radius_mm([x, y, z]: [f64; 3]) -> f64 {
    40.0 + 9.0 * x * y + 8.0 * x * z * z - 6.0 * y * y * z + 7.0 * x - 5.0 * y + 4.0 * x * y * z
}

impl Planted {
    pub(super) fn new(count: usize) -> Self {
        let mesh = mesh();
        let points = (0..count as u64)
            .map(|number| {
                let chance = Chance::new(7, number);
                let corners = mesh.triangles[(chance.uniform(0) * mesh.triangles.len() as f64) as usize];
                let [a, b, c] = corners.map(|corner| mesh.points[corner as usize].mm());
                let (u, v) = (chance.uniform(1).sqrt(), chance.uniform(2));
                let weights = [1.0 - u, u * (1.0 - v), u * v];
                let place = |k: usize| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k];
                [0, 1, 2].map(|k| place(k) + NOISE_MM * chance.normal(3 + k as u64))
            })
            .collect();
        let turn = Vector::new(0.4, -1.1, 0.7);
        let ct_from_tracker = Rigid::from_rotation_vector(turn, Vector::new(120.0, -60.0, 900.0)).unwrap();
        Self {
            ct_from_tracker,
            mesh,
            points,
        }
    }

    /// The bone, with its axes in the comment.
    pub(super) fn ply(&self) -> Vec<u8> {
        write(&self.mesh, MeshFormat::Ply, PatientAxes::Lps).unwrap()
    }

    pub(super) fn csv(&self) -> String {
        self.text(|p| p, 1.0)
    }

    /// Points of the patient's mirror image.
    pub(super) fn mirrored_csv(&self) -> String {
        self.text(|[x, y, z]| [-x, y, z], 1.0)
    }

    pub(super) fn scaled_csv(&self, scale: f64) -> String {
        self.text(|p| p, scale)
    }

    /// Points of skin: so far outside of the bone.
    pub(super) fn skin_csv(&self, mm: f64) -> String {
        let out = |p: [f64; 3]| {
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            p.map(|x| x * (1.0 + mm / length))
        };
        self.text(out, 1.0)
    }

    /// The last points of a bone that was moved before them.
    pub(super) fn moved_csv(&self, last: usize, mm: f64) -> String {
        let text = self.csv();
        let rows: Vec<&str> = text.lines().collect();
        let still = rows.len() - last;
        let moved = rows[still..].iter().map(|row| {
            let (x, rest) = row.split_once(',').unwrap();
            format!("{},{rest}", x.parse::<f64>().unwrap() + mm)
        });
        let lines: Vec<String> = rows[..still].iter().map(|row| (*row).to_owned()).chain(moved).collect();
        lines.join("\n") + "\n"
    }

    fn text(&self, change: impl Fn([f64; 3]) -> [f64; 3], scale: f64) -> String {
        let mut text = "x,y,z\n".to_owned();
        for point in &self.points {
            let [x, y, z] = change(*point);
            let seen = self.ct_from_tracker.inverse() * Point::<Ct>::new(x, y, z);
            let [x, y, z] = seen.mm().map(|mm| mm * scale);
            text += &format!("{x},{y},{z}\n");
        }
        text
    }

    /// Three of the points in both frames, some millimetres off.
    pub(super) fn landmarks(&self) -> String {
        let mut text = "from_x,from_y,from_z,to_x,to_y,to_z\n".to_owned();
        for (k, off) in [(3, 2.0), (40, -3.0), (90, 1.0)] {
            let [x, y, z] = self.points[k];
            let [a, b, c] = (self.ct_from_tracker.inverse() * Point::<Ct>::new(x, y, z)).mm();
            text += &format!("{a},{b},{c},{},{y},{}\n", x + off, z - off);
        }
        text
    }
}

/// Each face of an octahedron cut into smaller ones, all blown up to the bone's radius.
pub(in crate::surface) fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    for octant in 0..8_u32 {
        let sign = [0, 1, 2].map(|k| if octant >> k & 1 == 1 { -1.0 } else { 1.0 });
        let is_turned = sign.iter().product::<f64>() < 0.0;
        let corner = |i: u32, j: u32| {
            let [a, b] = [i, j].map(|n| f64::from(n) / f64::from(CUTS));
            let v = [a * sign[0], b * sign[1], (1.0 - a - b) * sign[2]];
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let unit = v.map(|x| x / length);
            // A zero of either sign is one place.
            let [x, y, z] = unit.map(|x| x * radius_mm(unit) + 0.0);
            Point::new(x, y, z)
        };
        let mut face = |corners: [(u32, u32); 3]| {
            let first = mesh.points.len() as u32;
            mesh.points.extend(corners.map(|(i, j)| corner(i, j)));
            let [a, b, c] = [first, first + 1, first + 2];
            mesh.triangles.push(if is_turned { [a, c, b] } else { [a, b, c] });
        };
        for i in 0..CUTS {
            for j in 0..CUTS - i {
                face([(i, j), (i + 1, j), (i, j + 1)]);
                if i + j + 2 <= CUTS {
                    face([(i + 1, j), (i + 1, j + 1), (i, j + 1)]);
                }
            }
        }
    }
    mesh
}
