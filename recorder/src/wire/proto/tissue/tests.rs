use super::*;
use prost::Message as _;

fn frame() -> TissueFrame {
    TissueFrame {
        header: TissueHeader {
            seq: u64::MAX,
            pose_seq: 3,
            t_capture_ns: i64::MIN,
            t_publish_ns: i64::MAX,
            registration_id: 0xfeed,
            mesh_id: std::array::from_fn(|k| k as u8),
            factor: 7,
            residual: f64::MIN_POSITIVE,
            unsettled_mm: -0.0,
            left_mm: 0.0,
            force: [1.0, -0.0, f64::MAX],
            moment: [0.5, 0.25, -3.0],
            depth_mm: 1e-9,
            least_determinant: 0.6,
            energy: -1.5,
            steps: 11,
            state: 1,
            errors_pose_seq: 2,
            errors_t_capture_ns: -7,
            errors_known: 2,
            errors: std::array::from_fn(|k| match k {
                0 | 1 => PlaceError {
                    at_rest_mm: [1.0, -0.0, k as f64],
                    covariance: [f64::MIN_POSITIVE, -0.0, f64::MAX, 0.1, 0.2, 0.3],
                },
                _ => PlaceError::default(),
            }),
            force_covariance: [f64::MIN_POSITIVE, -0.0, f64::MAX, 0.1, 0.2, 0.3],
            force_error_known: 1,
            ..TissueHeader::default()
        }
        .because("a point is 3.2 mm deep"),
        nodes: vec![0.0, -0.0, f32::MIN_POSITIVE, -1e4, 3.5, f32::MAX],
    }
}

fn mesh() -> MeshFrame {
    MeshFrame {
        header: TissueMeshHeader {
            mesh_id: [1; 32],
            volume_hash: [2; 32],
            q: [1.0, 0.0, -0.0, 0.0],
            t_mm: [0.0, -0.0, 1e3],
            organs: 1,
        },
        bytes: vec![0, 255, 7],
    }
}

#[test]
fn states_and_meshes_come_back_bit_for_bit() {
    let back = decode_tissue(&TissueState::from(&frame()).encode_to_vec()).unwrap();
    assert_eq!(bytemuck::bytes_of(&back.header), bytemuck::bytes_of(&frame().header));
    assert_eq!(
        back.nodes.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        frame().nodes.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    );
    let back = decode_mesh(&TissueMesh::of(5, &mesh()).encode_to_vec()).unwrap();
    assert_eq!(bytemuck::bytes_of(&back.header), bytemuck::bytes_of(&mesh().header));
    assert_eq!(back.bytes, mesh().bytes);
}

/// As files have it that were recorded before states told errors.
#[test]
fn a_state_without_errors_has_none_that_are_known() {
    let mut state = TissueState::from(&frame());
    (state.errors, state.errors_pose_seq, state.errors_t_capture_ns) = (Vec::new(), 0, 0);
    (state.why, state.force_covariance) = (String::new(), Vec::new());
    let back = decode_tissue(&state.encode_to_vec()).unwrap();
    assert_eq!((back.header.errors_known, back.header.why()), (0, ""));
    assert_eq!(back.header.error_of([0.0; 3]), None);
    assert_eq!((back.header.force_error_known, back.header.force_95_n().1), (0, None));
}

#[test]
fn what_is_no_state_is_refused_with_its_field() {
    let refused = |change: fn(&mut TissueState), field: &str| {
        let mut state = TissueState::from(&frame());
        change(&mut state);
        let words = decode_tissue(&state.encode_to_vec()).unwrap_err().to_string();
        assert!(words.contains(field), "{words}");
    };
    refused(
        |state| state.mesh_id.truncate(31),
        "mesh_id has 31 values instead of 32",
    );
    refused(|state| state.force.push(0.0), "force");
    refused(|state| state.moment.clear(), "moment");
    refused(|state| state.certificate.truncate(5), "certificate");
    refused(|state| state.errors.truncate(17), "errors has 17 values instead of 9");
    refused(
        |state| state.errors = vec![0.0; 9 * 17],
        "errors has 153 values instead of 144",
    );
    refused(
        |state| state.force_covariance.truncate(5),
        "force_covariance has 5 values instead of 6",
    );
    refused(|state| state.nodes.truncate(23), "nodes has 23 values instead of 24");
    assert!(
        decode_tissue(&[0xff; 7])
            .unwrap_err()
            .to_string()
            .contains("trocar.TissueState")
    );
    let cut = TissueMesh {
        q: vec![1.0; 3],
        ..TissueMesh::of(0, &mesh())
    };
    assert!(
        decode_mesh(&cut.encode_to_vec())
            .unwrap_err()
            .to_string()
            .contains("q has 3")
    );
    assert!(decode_mesh(&[0xff; 7]).is_err());
}
