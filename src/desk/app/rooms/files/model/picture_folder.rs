//! Pictures that another program made, opened beside a scene to be compared with.

use std::sync::Arc;

use crate::app::rooms::compare::model::vantage::CompareVantage;
use overlook_engine::capture::TruthLoader;
use overlook_engine::capture::transforms::OtherPictures;

/// A folder of pictures by another program.
#[derive(Clone)]
pub(crate) struct PictureFolder {
    /// Differs between any two folders that were ever opened.
    pub id: u64,
    /// Of the viewpoints with true pictures, in their order; `None` where it has pictures of none.
    pub of_views: Option<Arc<OtherPictures>>,
    /// Of every camera at every frame, camera by camera; `None` where it has pictures of none.
    pub of_cameras: Option<Arc<OtherPictures>>,
    /// Frames of each camera.
    pub frame_count: usize,
}

impl PartialEq for PictureFolder {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl PictureFolder {
    /// What is known of it: of viewpoints, or else of cameras.
    pub(crate) fn known(&self) -> impl Iterator<Item = &Arc<OtherPictures>> {
        self.of_views.iter().chain(&self.of_cameras)
    }

    /// The last part of its path.
    pub(crate) fn name(&self) -> String {
        self.known().next().map(|pictures| pictures.name()).unwrap_or_default()
    }

    /// Its path, and how its pictures were found.
    pub(crate) fn words(&self) -> String {
        let parts = [(&self.of_views, "viewpoints"), (&self.of_cameras, "frames of cameras")];
        let parts = parts.into_iter().filter_map(|(pictures, of)| {
            let pictures = pictures.as_ref()?;
            let (count, all, by) = (pictures.count(), pictures.pictures.len(), pictures.matched_by);
            Some(format!("{count} of {all} {of}, matched by {by}"))
        });
        let parts: Vec<String> = parts.collect();
        let folder = self.known().next().map(|pictures| pictures.folder.display().to_string());
        format!("{}: pictures of {}.", folder.unwrap_or_default(), parts.join("; and of "))
    }

    /// The picture of a viewpoint at a frame, or a sentence on why it is missing.
    pub(crate) fn picture(&self, from: CompareVantage, frame: usize) -> Result<TruthLoader, String> {
        let (pictures, index) = match from {
            CompareVantage::Live => (None, 0),
            CompareVantage::Truth(index) => (self.of_views.as_ref(), index),
            CompareVantage::HoldOut(camera) => (self.of_cameras.as_ref(), camera * self.frame_count + frame),
        };
        let nothing = || {
            let sources = [
                ("viewpoints with true pictures", &self.of_views),
                ("cameras that are held out", &self.of_cameras),
            ];
            let known: Vec<&str> =
                sources.into_iter().filter_map(|(name, pictures)| pictures.as_ref().map(|_| name)).collect();
            format!(
                "{} has pictures of {} alone: choose one in the last list above.",
                self.name(),
                known.join(" and ")
            )
        };
        let picture = pictures.and_then(|pictures| pictures.pictures.get(index)).ok_or_else(nothing)?;
        picture.clone().map_err(|reason| format!("{} {reason}.", self.name()))
    }

    /// The first viewpoint that it has a picture of, at a frame where it is a camera's.
    pub(crate) fn first(&self, frame: usize) -> Option<CompareVantage> {
        let has = |pictures: &Option<Arc<OtherPictures>>, index: usize| {
            pictures.as_ref().is_some_and(|pictures| pictures.pictures.get(index).is_some_and(Result::is_ok))
        };
        let length =
            |pictures: &Option<Arc<OtherPictures>>| pictures.as_ref().map_or(0, |it| it.pictures.len());
        let view = (0..length(&self.of_views)).find(|index| has(&self.of_views, *index));
        let cameras = 0..length(&self.of_cameras) / self.frame_count.max(1);
        let camera = || {
            let mut cameras = cameras.clone();
            let here = cameras.find(|camera| has(&self.of_cameras, camera * self.frame_count + frame));
            here.or_else(|| {
                let any = (0..length(&self.of_cameras)).find(|index| has(&self.of_cameras, *index))?;
                Some(any / self.frame_count.max(1))
            })
        };
        view.map(CompareVantage::Truth).or_else(|| camera().map(CompareVantage::HoldOut))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::capture::transforms::MatchedBy;

    /// A folder with pictures of the second of two viewpoints and of the second of two cameras at the first of three frames.
    fn folder() -> PictureFolder {
        let pictures = |known: usize, all: usize| {
            let load: TruthLoader = Arc::new(|| Err(overlook_engine::error::Error::Cancelled));
            let of =
                |index: usize| if index == known { Ok(load.clone()) } else { Err(format!("lacks {index}")) };
            Some(Arc::new(OtherPictures {
                folder: "/made/rvs".into(),
                matched_by: MatchedBy::FileName,
                pictures: (0..all).map(of).collect(),
                left_over: Vec::new(),
            }))
        };
        PictureFolder { id: 1, of_views: pictures(1, 2), of_cameras: pictures(3, 6), frame_count: 3 }
    }

    #[test]
    fn a_folder_says_what_it_has_pictures_of_and_what_it_lacks() {
        let folder = folder();
        assert!(folder.picture(CompareVantage::Truth(1), 0).is_ok());
        assert!(folder.picture(CompareVantage::HoldOut(1), 0).is_ok());
        let trouble = |from, frame| folder.picture(from, frame).err().unwrap();
        assert_eq!(trouble(CompareVantage::Truth(0), 0), "rvs lacks 0.");
        assert_eq!(trouble(CompareVantage::HoldOut(1), 2), "rvs lacks 5.");
        assert!(trouble(CompareVantage::Live, 0).contains(
            "rvs has pictures of viewpoints with true pictures and cameras that are held out alone"
        ));
        assert_eq!(folder.first(2), Some(CompareVantage::Truth(1)));
        let words = folder.words();
        assert!(
            words.contains("1 of 2 viewpoints, matched by file name; and of 1 of 6 frames of cameras"),
            "{words}"
        );
        let cameras = PictureFolder { of_views: None, ..folder };
        assert_eq!(cameras.first(2), Some(CompareVantage::HoldOut(1)));
    }
}
