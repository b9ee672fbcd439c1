//! The methods, from the same table that the command line and the manual read.

use serde::Serialize;
use utoipa::ToSchema;

use super::json_answer::Json;
use crate::method::{self, MethodEntry, ParameterHelp};

/// All methods.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct MethodList {
    /// The first one is the default.
    pub methods: Vec<MethodView>,
}

/// One method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct MethodView {
    /// The name to ask for.
    pub name: &'static str,
    /// What it does.
    pub summary: &'static str,
    /// Light that it does not find.
    pub cannot_sample: &'static str,
    /// Where it was published.
    pub reference: &'static str,
    /// What can be set.
    pub parameters: Vec<ParameterView>,
}

/// One parameter of a method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct ParameterView {
    /// Its name.
    pub name: &'static str,
    /// What it means, with its unit.
    pub meaning: &'static str,
    /// Values it may take.
    pub range: &'static str,
    /// What it is when it is not given.
    pub default: &'static str,
}

impl From<&MethodEntry> for MethodView {
    fn from(entry: &MethodEntry) -> Self {
        let MethodEntry { name, summary, cannot_sample, reference, parameters, .. } = *entry;
        let parameters = parameters.iter().map(ParameterView::from).collect();
        Self { name, summary, cannot_sample, reference, parameters }
    }
}

impl From<&ParameterHelp> for ParameterView {
    fn from(help: &ParameterHelp) -> Self {
        let ParameterHelp { name, meaning, range, default } = *help;
        Self { name, meaning, range, default }
    }
}

/// Lists the methods.
#[utoipa::path(
    get, path = "/methods", tag = "jobs",
    responses((status = 200, description = "All methods, the default first", body = MethodList))
)]
pub(crate) async fn list_methods() -> Json<MethodList> {
    Json(MethodList { methods: method::table().iter().map(MethodView::from).collect() })
}
