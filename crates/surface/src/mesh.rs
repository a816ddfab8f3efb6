//! Triangles in the patient.

/// A surface of triangles. Corners go anticlockwise where they are seen from outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Places, CT, LPS mm.
    pub(crate) points: Vec<[f32; 3]>,
    /// Of unit length, outwards; zero where nothing says where that is.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Three places each.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The colour of each triangle, by its place in a list.
    pub(crate) paints: Vec<u8>,
}

impl Mesh {
    /// A surface of these triangles in one colour, the first of a list; smooth, its normals being those of the triangles that meet at each
    /// corner. `None` where a triangle names a corner that is not there.
    pub fn of_triangles(points: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Option<Self> {
        let is_there = |corner: &u32| (*corner as usize) < points.len();
        if !triangles.iter().flatten().all(is_there) {
            return None;
        }
        let paints = vec![0; triangles.len()];
        let mut mesh = Self {
            points,
            normals: Vec::new(),
            triangles,
            paints,
        };
        mesh.make_normals();
        Some(mesh)
    }

    /// The corners, CT, LPS mm.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// The triangles, each three places in [`Mesh::points`].
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The colour of each triangle, by its place in the list that [`ZBuffer::draw`](crate::ZBuffer::draw) is given.
    pub fn paints(&self) -> &[u8] {
        &self.paints
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Takes everything out and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.normals.clear();
        self.triangles.clear();
        self.paints.clear();
    }

    /// The normals of all corners, from the triangles that meet there: each counts by its area.
    pub(crate) fn make_normals(&mut self) {
        self.normals.clear();
        self.normals.resize(self.points.len(), [0.0; 3]);
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| self.points[corner as usize]);
            let across = cross(minus(b, a), minus(c, a));
            for corner in triangle {
                let normal = &mut self.normals[*corner as usize];
                *normal = [0, 1, 2].map(|axis| normal[axis] + across[axis]);
            }
        }
        for normal in &mut self.normals {
            let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
            if length > 0.0 {
                *normal = normal.map(|c| c / length);
            }
        }
    }
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
