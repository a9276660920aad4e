//! What is left when a driver is reset, or a graphics card is taken away.

use compute::receivers::ReceiverId;
use compute::rows::{BackendError, RowSource};
use scene::PatchId;

use crate::model::{frame, room};
use crate::{open, settings};

pub fn a_lost_device_is_an_error_from_then_on_and_no_panic() {
    let scene = room().scene(0.5);
    let mut gpu = open(&scene, settings(20));
    assert_eq!(gpu.draw_rows(0..4).unwrap().receivers(), 0..4);
    gpu.lose_device();
    for _ in 0..3 {
        let lost = gpu.draw_rows(4..8);
        assert!(
            matches!(lost, Err(BackendError::DeviceLost { .. })),
            "{lost:?}"
        );
    }
    let lost = gpu.item_buffer(ReceiverId(0), &frame(&scene, PatchId(0)));
    assert!(
        matches!(lost, Err(BackendError::DeviceLost { .. })),
        "{lost:?}"
    );
}
