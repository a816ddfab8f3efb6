use super::*;
use crate::testing;
use proptest::prelude::*;
use prost::Message as _;

/// Every bit pattern, NaN payloads, infinities, denormals and -0.0 among them.
fn bits() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        Just(-0.0),
        Just(f64::from_bits(0x7ff0_0000_0000_0001)),
        Just(f64::from_bits(0xfff8_dead_beef_0001)),
    ]
}

prop_compose! {
    fn pose()(
        numbers in any::<(u64, i64, i64, i64, u64, u32, u32)>(),
        q in prop::array::uniform4(bits()),
        t_mm in prop::array::uniform3(bits()),
        covariance in prop::array::uniform21(bits()),
        fre_rms_mm in bits(),
        tip_mm in bits(),
        rest in any::<(i64, u32, u32)>(),
    ) -> message::ToolPose {
        let (seq, t_device_ns, t_capture_ns, t_publish_ns, registration_id, status, visible) = numbers;
        message::ToolPose {
            seq, t_device_ns, t_capture_ns, t_publish_ns, registration_id, status, visible,
            q, t_mm, covariance, fre_rms_mm,
            tip_mm, delay_ns: rest.0, used: rest.1, flags: rest.2,
        }
    }
}

proptest! {
    #[test]
    fn poses_come_back_bit_for_bit(pose in pose()) {
        let back = decode_pose(&ToolPose::from(&pose).encode_to_vec()).unwrap();
        prop_assert_eq!(testing::bytes(&back), testing::bytes(&pose));
    }

    #[test]
    fn hostile_bytes_are_refused_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = decode_pose(&bytes);
    }
}

#[test]
fn the_zero_message_comes_back_with_the_sign_of_its_zeros() {
    let mut pose = message::ToolPose::EMPTY;
    pose.fre_rms_mm = -0.0;
    pose.t_mm[1] = -0.0;
    let back = decode_pose(&ToolPose::from(&pose).encode_to_vec()).unwrap();
    assert_eq!(testing::bytes(&back), testing::bytes(&pose));
}

#[test]
fn a_wrong_number_of_values_is_named() {
    let mut pose = ToolPose::from(&testing::pose(7));
    pose.covariance.pop();
    let text = decode_pose(&pose.encode_to_vec()).unwrap_err().to_string();
    assert_eq!(text, "message 7: covariance has 20 values instead of 21");
    pose.covariance.push(0.0);
    pose.fre_rms_mm = None;
    let text = decode_pose(&pose.encode_to_vec()).unwrap_err().to_string();
    assert_eq!(text, "message 7: fre_rms_mm has 0 values instead of 1");
}

#[test]
fn foxglove_gets_metres_and_its_own_order_of_the_quaternion() {
    let pose = testing::pose(3);
    let tf = frame_transform_in_metres(&pose, "tool").unwrap();
    let translation = tf.translation.unwrap();
    let expected = pose.t_mm.map(|mm| mm / 1e3);
    assert_eq!([translation.x, translation.y, translation.z], expected);
    let q = tf.rotation.unwrap();
    assert_eq!([q.w, q.x, q.y, q.z], pose.q);
    assert_eq!(
        (tf.parent_frame_id.as_str(), tf.child_frame_id.as_str()),
        ("ct", "tool")
    );
    let stamp = tf.timestamp.unwrap();
    assert_eq!(
        stamp.seconds * 1_000_000_000 + i64::from(stamp.nanos),
        pose.t_capture_ns
    );
}

#[test]
fn lost_and_impossible_poses_have_no_transform() {
    let mut pose = testing::pose(0);
    pose.q[0] = f64::NAN;
    assert_eq!(frame_transform_in_metres(&pose, "tool"), None);
    assert_eq!(frame_transform_in_metres(&message::ToolPose::EMPTY, "tool"), None);
}

#[test]
fn stamps_before_the_epoch_count_as_the_epoch() {
    assert_eq!(file_time(-5), 0);
    assert_eq!(file_time(i64::MIN), 0);
    assert_eq!(file_time(i64::MAX), i64::MAX.unsigned_abs());
}
