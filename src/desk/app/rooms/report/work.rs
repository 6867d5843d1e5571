//! Prunes the open capture: all of it, or the frame shown.

use std::sync::Arc;
use std::time::Instant;

use crate::app::model::{Inspected, Message};
use crate::app::work::outbox::Outbox;
use crate::app::work::requests::PruneRequest;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess;
use overlook_engine::preprocess::diagnostics::PixelAccount;

/// Prunes a whole capture, after the pass over its frames.
pub(crate) fn prune_whole(request: PruneRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let PruneRequest { scene, scan, settings, .. } = request;
    let capture = scene.source()?;
    let mut read_seconds = None;
    let scan = if let Some(scan) = scan.filter(|scan| scan.serves(&settings)) {
        scan
    } else {
        let started = Instant::now();
        let scan = preprocess::scan(capture, &settings, job)?;
        read_seconds = Some(started.elapsed().as_secs_f64());
        outbox.send(Message::Scanned { scene: scene.id, scan: scan.clone() });
        scan
    };
    let result = preprocess::prune(capture, &scan, &settings, job)?;
    Ok(Message::Pruned { scene: scene.id, settings, result: Arc::new(result), read_seconds })
}

/// Prunes one frame, with reasons.
pub(crate) fn inspect(request: PruneRequest, job: &Job) -> Result<Message> {
    let PruneRequest { scene, scan, settings, frame } = request;
    let inspection = preprocess::inspect_frame(scene.source()?, scan.as_deref(), &settings, frame, job)?;
    let mut kept = vec![0; inspection.cameras.len()];
    for image in &inspection.samples.images {
        kept[image.camera as usize] += image.len() as u64;
    }
    let verdicts = inspection.cameras.iter().flat_map(|camera| camera.verdict.as_slice());
    let account = PixelAccount::of_frame(verdicts.map(|verdict| verdict.rule));
    let inspection = Arc::new(inspection);
    let inspected = Inspected { inspection, settings, with_scan: scan.is_some(), kept, account };
    Ok(Message::Inspected { scene: scene.id, inspected })
}

/// Makes a frame ready for its thresholds to be turned.
pub(crate) fn prepare(request: &PruneRequest, job: &Job) -> Result<Message> {
    if let (capture, Some(scan)) = (request.scene.source()?, &request.scan) {
        preprocess::prepare_frame(capture, scan, &request.settings, request.frame, job)?;
    }
    Ok(Message::Prepared)
}
