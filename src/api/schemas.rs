//! Schemas of what is read elsewhere: bytes, scenes and what is changed of them. Layers below know nothing of OpenAPI.

use std::borrow::Cow;

use utoipa::openapi::schema::{KnownFormat, ObjectBuilder, OneOfBuilder, SchemaFormat, Type};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// Bytes that are no text, as their media type says.
pub(crate) struct Bytes;

impl PartialSchema for Bytes {
    fn schema() -> RefOr<Schema> {
        let bytes = ObjectBuilder::new().schema_type(Type::String);
        bytes.format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary))).build().into()
    }
}

impl ToSchema for Bytes {}

/// A scene that stands in a request.
pub(crate) struct InlineScene;

impl PartialSchema for InlineScene {
    fn schema() -> RefOr<Schema> {
        let dictionary = ObjectBuilder::new()
            .schema_type(Type::Object)
            .description(Some("A dictionary as Mitsuba 3's `load_dict` takes it"));
        let text = ObjectBuilder::new().schema_type(Type::String).description(Some("Mitsuba 3 XML"));
        Schema::from(OneOfBuilder::new().item(dictionary).item(text).build()).into()
    }
}

impl ToSchema for InlineScene {}

/// What is changed of a scene: [`crate::farm::job::SceneChanges`].
pub(crate) struct Changes;

impl PartialSchema for Changes {
    fn schema() -> RefOr<Schema> {
        let text = |description: &str| {
            ObjectBuilder::new().schema_type(Type::String).description(Some(description.to_owned()))
        };
        let environment =
            text("Whether a white environment of radiance 1 lights the scene").enum_values(Some(["on", "off"]));
        let properties = ObjectBuilder::new()
            .schema_type(Type::Object)
            .description(Some("What is changed of a scene; what is left out stays as the scene says"))
            .property(
                "width",
                pixels("Width of the whole picture, pixels; alone it keeps the picture's proportions", 1),
            )
            .property(
                "height",
                pixels("Height of the whole picture, pixels; alone it keeps the picture's proportions", 1),
            )
            .property("crop", crop())
            .property("camera", text("The name of a camera, or its index among the scene's, from 0"))
            .property("environment", environment)
            .property(
                "time",
                number("The moment that is shown of a scene in which things move, in the scene's own unit"),
            )
            .property("between_cameras", between_cameras());
        closed(properties)
    }
}

impl ToSchema for Changes {
    fn name() -> Cow<'static, str> {
        "SceneChanges".into()
    }
}

fn crop() -> RefOr<Schema> {
    let names = ["x", "y", "width", "height"];
    let part = ObjectBuilder::new()
        .schema_type(Type::Object)
        .description(Some("The part of the whole picture that is rendered, pixels"))
        .property("x", pixels("First column", 0))
        .property("y", pixels("First row", 0))
        .property("width", pixels("How many columns", 1))
        .property("height", pixels("How many rows", 1));
    closed(names.into_iter().fold(part, ObjectBuilder::required))
}

fn between_cameras() -> RefOr<Schema> {
    let camera = |which: &str| {
        let description = format!("The name of the camera that {which}, or its index among the scene's, from 0");
        ObjectBuilder::new().schema_type(Type::String).description(Some(description))
    };
    let way = ObjectBuilder::new()
        .schema_type(Type::Object)
        .description(Some("A camera between two of the scene's, in place of `camera`"))
        .property("from", camera("the way begins at"))
        .property("to", camera("it ends at"))
        .property("share", number("The share of the way, from 0 to 1"));
    closed(["from", "to", "share"].into_iter().fold(way, ObjectBuilder::required))
}

fn number(description: &str) -> ObjectBuilder {
    let number = ObjectBuilder::new().schema_type(Type::Number).description(Some(description.to_owned()));
    number.format(Some(SchemaFormat::KnownFormat(KnownFormat::Double)))
}

fn pixels(description: &str, least: u32) -> ObjectBuilder {
    let count = ObjectBuilder::new().schema_type(Type::Integer).description(Some(description.to_owned()));
    count.format(Some(SchemaFormat::KnownFormat(KnownFormat::Int32))).minimum(Some(least))
}

/// An object that has no other fields.
fn closed(object: ObjectBuilder) -> RefOr<Schema> {
    use utoipa::openapi::schema::AdditionalProperties;
    object.additional_properties(Some(AdditionalProperties::<Schema>::FreeForm(false))).build().into()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use serde_json::{Value, json};

    use super::*;
    use crate::farm::job::SceneChanges;

    /// The fields of an object, in no order: documents and descriptions each have their own.
    fn names(object: &Value) -> BTreeSet<&String> {
        object.as_object().expect("an object").keys().collect()
    }

    /// Whatever is described is read, and nothing else is.
    #[test]
    fn changes_are_described_as_they_are_read() {
        let all = json!({ "width": 1, "height": 1, "crop": { "x": 0, "y": 0, "width": 1, "height": 1 }, "camera": "0", "environment": "on",
            "time": 0.5, "between_cameras": { "from": "0", "to": "1", "share": 0.5 } });
        let read: SceneChanges = serde_json::from_value(all.clone()).expect("all of it is read");
        let written = serde_json::to_value(read).expect("JSON");
        let described = serde_json::to_value(Changes::schema()).expect("JSON");
        assert_eq!(written, all);
        assert_eq!(names(&described["properties"]), names(&all));
        assert_eq!(names(&described["properties"]["crop"]["properties"]), names(&all["crop"]));
        assert_eq!(names(&described["properties"]["between_cameras"]["properties"]), names(&all["between_cameras"]));
    }
}
