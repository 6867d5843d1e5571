//! Prunes the open capture: all of it, or the frame shown.

use std::sync::Arc;

use crate::app::model::{Inspected, Message};
use crate::app::work::requests::PruneRequest;
use crate::app::work::worker::Outbox;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess;

/// Prunes a whole capture, after the pass over its frames.
pub(crate) fn prune_whole(request: PruneRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let PruneRequest { scene, scan, settings, .. } = request;
    let capture = scene.source()?;
    let scan = if let Some(scan) = scan.filter(|scan| scan.serves(&settings)) {
        scan
    } else {
        let scan = preprocess::scan(capture, &settings, job)?;
        outbox.send(Message::Scanned { scene: scene.id, scan: scan.clone() });
        scan
    };
    let result = preprocess::prune(capture, &scan, &settings, job)?;
    Ok(Message::Pruned { scene: scene.id, settings, result: Arc::new(result) })
}

/// Prunes one frame, with reasons.
pub(crate) fn inspect(request: PruneRequest, job: &Job) -> Result<Message> {
    let PruneRequest { scene, scan, settings, frame } = request;
    let inspection = preprocess::inspect_frame(scene.source()?, scan.as_deref(), &settings, frame, job)?;
    let mut kept = vec![0; inspection.cameras.len()];
    for image in &inspection.samples.images {
        kept[image.camera as usize] += image.len() as u64;
    }
    let inspected = Inspected { inspection: Arc::new(inspection), settings, with_scan: scan.is_some(), kept };
    Ok(Message::Inspected { scene: scene.id, inspected })
}

/// Makes a frame ready for its thresholds to be turned.
pub(crate) fn prepare(request: &PruneRequest, job: &Job) -> Result<Message> {
    if let (capture, Some(scan)) = (request.scene.source()?, &request.scan) {
        preprocess::prepare_frame(capture, scan, &request.settings, request.frame, job)?;
    }
    Ok(Message::Prepared)
}
