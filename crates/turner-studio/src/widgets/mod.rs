//! Widgets for the values of a scene.

pub(crate) mod color;
pub(crate) mod compound;
pub(crate) mod field;
pub(crate) mod kind;
pub(crate) mod light;
pub(crate) mod start;
pub(crate) mod transform;

use egui::{Response, Role, Ui, WidgetInfo, WidgetText};

/// An entry of a list that opens. Choosing it closes the list, also for those who choose without a pointer.
pub(crate) fn entry<'a>(
    ui: &mut Ui,
    is_chosen: bool,
    text: impl Into<WidgetText> + egui::IntoAtoms<'a>,
) -> Response {
    let response = ui.selectable_label(is_chosen, text);
    if response.clicked() {
        ui.close();
    }
    response
}

/// Names a widget for screen readers and tests.
pub(crate) fn name(response: &Response, role: Role, name: &str) {
    let name = name.replace('_', " ");
    response.widget_info(|| WidgetInfo::labeled(role, true, &name));
}

/// Names a number, which keeps its value.
pub(crate) fn name_number(response: &Response, name: &str, value: f64) {
    let name = name.replace('_', " ");
    response.widget_info(|| WidgetInfo { label: Some(name.clone()), ..WidgetInfo::drag_value(true, value) });
}

/// Names a switch, which keeps its state.
pub(crate) fn name_switch(response: &Response, name: &str, on: bool) {
    let name = name.replace('_', " ");
    response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, on, &name));
}

/// Names a field of text, which keeps its text.
pub(crate) fn name_text(response: &Response, name: &str, text: &str) {
    let name = name.replace('_', " ");
    response.widget_info(|| WidgetInfo {
        label: Some(name.clone()),
        current_text_value: Some(text.to_owned()),
        ..WidgetInfo::new(Role::TextInput)
    });
}
