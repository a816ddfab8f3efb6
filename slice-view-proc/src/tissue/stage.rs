//! What tests of images with organs share: organs that are cubes, where a state has them, and a scene and an examination for them.

use bus::message::{Marks, MeshCube, MeshOrgan, TissueHeader, TissueMesh, TissueMeshHeader, VolumeHash};
use bus::volume::{Layout, OwnedVolume, Voxels};
use geometry::{Affine, Ct, Rigid, Tool, Vector, VolumeGrid};
use scene::{Scene, WindowLevel};

use super::{Answers, Shapes};
use crate::overlay::{Notice, Origin};
use crate::render::Rendered;

/// Sides of voxels are 1 mm, and a pixel along x has this more HU than the one before it, mm away.
pub(crate) const HU_PER_MM: f64 = 4.0;
/// Where the tool's tip is, mm; the middle of the images.
pub(crate) const TIP: [f64; 3] = [50.0; 3];
/// Of the images: pixels of a side, and mm of a pixel.
pub(crate) const SIDE: usize = 256;
pub(crate) const PIXEL_MM: f64 = 100.0 / SIDE as f64;

/// A scene whose tube moves organs, with one image across the patient that has the whole examination.
pub(crate) fn scene() -> Scene {
    let text = format!(
        "[tissue]\norgans = \"o.toml\"\n[[targets]]\nname = \"t\"\nct_mm = [64, 50, 90]\n[[views]]\nname = \"across\"\nplane = \"axial\"\n\
         extent = \"local\"\nfield_mm = 100.0\nsize = [{SIDE}, {SIDE}]\n"
    );
    let mut scene = Scene::parse(&text, std::path::Path::new("s.toml")).unwrap();
    scene.views[0].window = WindowLevel {
        centre_hu: 40.0,
        width_hu: 400.0,
    };
    scene
}

/// 100 voxels of 1 mm along each axis whose HU grow along x, from the left end of the window of [`scene`] to its right one.
pub(crate) fn volume() -> OwnedVolume {
    let layout = Layout::choose([100; 3]).unwrap();
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    let slice: Vec<i16> = (0..10_000).map(|at| hu_at(f64::from(at % 100)) as i16).collect();
    (0..100).for_each(|z| layout.scatter(z, &slice, &mut voxels));
    let unit = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    OwnedVolume {
        grid: VolumeGrid::checked([100; 3], Affine::from_rows(unit)).unwrap(),
        layout,
        voxels,
        padding_hu: -1024,
        hash: VolumeHash([7; 32]),
        marks: Marks::NONE,
    }
}

pub(crate) fn hu_at(x: f64) -> f64 {
    HU_PER_MM * x - 160.0
}

/// The tool along z.
pub(crate) fn pose() -> Rigid<Ct, Tool> {
    let [x, y, z] = TIP;
    Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), Vector::new(x, y, z)).unwrap()
}

/// What is drawn of it: a live image with the organs of `tissue`.
pub(crate) fn rendered<'a>(volume: &'a OwnedVolume, notice: Notice) -> Rendered<'a> {
    Rendered {
        volume: volume.view(),
        volume_name: "01234567",
        marks: volume.marks,
        pose: Some(pose()),
        accuracy: None,
        notice,
        origin: Origin::Tracker,
        remarks: &[],
        chosen: None,
        seq: 5,
        registration_id: 9,
        tissue: super::Tissues::default(),
    }
}

/// A cube of an organ: its middle and its side, mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block(pub(crate) [f64; 3], pub(crate) f64);

impl Block {
    fn low(self) -> [f64; 3] {
        self.0.map(|x| x - 0.5 * self.1)
    }

    /// Its 27 nodes, each moved by what `by` says of its place at rest.
    pub(crate) fn nodes(self, by: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f32; 3]> {
        let node = |k: usize| {
            let along = [k % 3, k / 3 % 3, k / 9];
            let at: [f64; 3] = std::array::from_fn(|a| self.low()[a] + 0.5 * self.1 * along[a] as f64);
            let by = by(at);
            std::array::from_fn(|a| (at[a] + by[a]) as f32)
        };
        (0..27).map(node).collect()
    }

    /// Wholly organ, to its faces.
    fn organ(self) -> MeshOrgan {
        MeshOrgan {
            name: "cube".to_owned(),
            nodes: 27,
            cubes: vec![MeshCube {
                low: self.low(),
                side: self.1,
                nodes: std::array::from_fn(|k| k as u32),
            }],
            region_origin: self.low(),
            region_step_mm: self.1,
            region_dims: [2; 3],
            region: vec![-1.0; 8],
        }
    }
}

/// The message of these organs.
pub(crate) fn mesh(blocks: &[Block]) -> (TissueMeshHeader, Vec<u8>) {
    let mesh = TissueMesh {
        ct_from_model: Rigid::identity(),
        volume_hash: [7; 32],
        organs: blocks.iter().map(|block| block.organ()).collect(),
    };
    mesh.write()
}

/// These organs as images have them, cut in pieces of 2 mm.
pub(crate) fn shapes(blocks: &[Block]) -> Shapes {
    let (header, bytes) = mesh(blocks);
    Shapes::read((&header, &bytes), &[7; 32], 2.0).unwrap()
}

/// One organ and the state with this header, its id put in.
pub(crate) fn answers(block: Block, header: TissueHeader, nodes: &[[f32; 3]]) -> Answers {
    let (mesh, bytes) = mesh(&[block]);
    let mut answers = Answers::new(2.0, 1e-3);
    answers.take_mesh((&mesh, &bytes), &[7; 32]).unwrap();
    let header = TissueHeader {
        mesh_id: mesh.mesh_id,
        ..header
    };
    answers.take_state(&header, nodes.as_flattened()).unwrap();
    answers
}
