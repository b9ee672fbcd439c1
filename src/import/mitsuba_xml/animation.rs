//! `<animation>`: a transform with key frames, as Mitsuba 0.6 writes it. Mitsuba 3 has none; here its scenes may use it, too.

use roxmltree::Node;

use super::super::motion::KeyFrame;
use super::super::values;
use super::super::xml_element::File;
use super::{Reader, Scope, parameter_path, refused};
use crate::scene::description::{Parameter, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

impl Reader<'_> {
    /// The transform that its key frames give at the moment that is shown.
    pub(super) fn animation(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        let path = parameter_path(element, scope);
        let place = file.place(element, path.as_str());
        let attributes = self.attributes(file, element, &path, &["name"], &[])?;
        let mut keys: Vec<KeyFrame> = Vec::new();
        for child in element.children() {
            if child.has_tag_name("transform") {
                keys.push(self.key_frame(file, child, &path, keys.last())?);
            } else if child.is_element() {
                let problem = format!("<animation> cannot hold a <{}>", child.tag_name().name());
                return Err(SceneError::new(&file.place(child, path), problem, "move it out"));
            } else {
                self.refuse_text(file, child, &path)?;
            }
        }
        let Some(matrix) = self.motion.place(&keys) else {
            return Err(SceneError::new(&place, "the <animation> has no <transform>", "give it one, or remove it"));
        };
        if self.motion.moment.is_none() && keys.len() > 1 {
            let explanation =
                "a picture shows one moment, the first; --time shows another, --frames one after the other";
            self.notices.push(Notice::approximated(&place, "the <animation>", explanation));
        }
        let (name, value) = (attributes.text("name").to_owned(), Value::Transform(matrix));
        scope.draft.parameters.push(Parameter { name, value, location: place });
        Ok(())
    }

    fn key_frame(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        path: &str,
        before: Option<&KeyFrame>,
    ) -> Result<KeyFrame, SceneError> {
        let place = file.place(element, path);
        let attributes = self.attributes(file, element, path, &["time"], &[])?;
        let time = values::float(attributes.text("time")).map_err(|refusal| refused(&place, "transform", refusal))?;
        if let Some(before) = before.filter(|before| before.time >= time) {
            let problem = format!("the key frame at {time} stands behind that at {}", before.time);
            return Err(SceneError::new(&place, problem, "put key frames in the order of their times"));
        }
        Ok(KeyFrame { time, place: self.steps(file, element, path)? })
    }
}
