//! The panel "Render" in a window without a display.

use std::time::{Duration, Instant};

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use turner_live::document::{Document, STARTS};
use turner_studio::app::App;
use turner_studio::jobs::State;
use turner_studio::studio::Dialog;

/// A window that shows the panel, with a small scene.
fn window(home: &std::path::Path) -> Harness<'static, App> {
    let mut app = App::new(&egui::Context::default(), home.to_owned());
    app.studio.jobs = crate::jobs::queue(home);
    let start = STARTS.iter().find(|start| start.name == "Cornell box").unwrap();
    let mut document = Document::start(start).unwrap();
    let small = document.edit("Small", None, |desc| {
        (desc.film.width, desc.film.height, desc.film.samples) = (32, 24, 2);
        Ok(())
    });
    small.unwrap();
    app.studio.show(document);
    let size = egui::vec2(1400.0, 900.0);
    let mut harness =
        Harness::builder().with_size(size).build_ui_state(|ui, app: &mut App| app.show(ui), app);
    harness.run_steps(2);
    harness.get_by_label("Panels").click();
    harness.run_steps(3);
    let last = harness.get_all_by_label("Render").last().unwrap();
    last.click();
    harness.run_steps(3);
    harness
}

#[track_caller]
fn until(harness: &mut Harness<'_, App>, what: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !what(harness.state()) {
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "{:?}",
            harness.state().studio.jobs.jobs()[0].report()
        );
        harness.step();
        std::thread::sleep(Duration::from_millis(10));
    }
    harness.run_steps(2);
}

#[test]
fn a_render_is_queued_shown_and_finished() {
    let home = tempfile::tempdir().unwrap();
    let mut harness = window(home.path());
    let output = home.path().join("out.png");
    let field = harness.get_by_label("Render to");
    field.focus();
    harness.run_steps(2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.run_steps(2);
    harness.get_by_label("Render to").type_text(output.to_str().unwrap());
    harness.run_steps(3);
    harness.get_by_label("Add to the queue").click();
    harness.run_steps(2);
    assert_eq!(harness.state().studio.jobs.jobs().len(), 1);
    assert_eq!(harness.state().studio.jobs.jobs()[0].spec.output, output);
    until(&mut harness, |app| !app.studio.jobs.is_busy());
    let report = harness.state().studio.jobs.jobs()[0].report();
    assert_eq!(report.state, State::Done, "{report:?}");
    assert!(output.is_file());
    harness.get_by_label("Open the folder out.png");
    harness.get_by_label("Remove out.png").click();
    harness.run_steps(3);
    assert!(harness.state().studio.jobs.jobs().is_empty());
}

#[test]
fn what_cannot_be_written_is_refused_in_the_form() {
    let home = tempfile::tempdir().unwrap();
    let mut harness = window(home.path());
    harness.get_by_label("Render to").focus();
    harness.run_steps(2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.run_steps(2);
    harness.get_by_label("Render to").type_text("/no/such/folder/a.png");
    harness.run_steps(3);
    harness.get_by_label("The folder does not exist");
    harness.get_by_label("Add to the queue").click();
    harness.run_steps(2);
    assert!(harness.state().studio.jobs.jobs().is_empty());
}

#[test]
fn closing_with_a_render_asks() {
    let home = tempfile::tempdir().unwrap();
    let mut harness = window(home.path());
    let app = harness.state_mut();
    let mut spec = turner_studio::jobs::Spec::new(home.path().join("a.png"));
    spec.end = turner_studio::jobs::End::Samples(1 << 20);
    let desc = app.studio.document.desc().clone();
    app.studio.jobs.add(desc, "box".into(), spec);
    until(&mut harness, |app| app.studio.jobs.jobs()[0].report().state == State::Rendering);
    harness.state_mut().studio.leave(turner_studio::studio::After::Quit);
    harness.run_steps(2);
    assert!(matches!(harness.state().studio.dialog, Some(Dialog::Jobs)));
    harness.get_by_label("Keep rendering").click();
    harness.run_steps(2);
    assert!(harness.state().studio.jobs.is_running() && !harness.state().studio.quit);
    harness.state_mut().studio.leave(turner_studio::studio::After::Quit);
    harness.run_steps(2);
    harness.get_by_label("Stop and close").click();
    harness.run_steps(2);
    // The changed scene asks next.
    assert!(matches!(harness.state().studio.dialog, Some(Dialog::Unsaved(_))));
    until(&mut harness, |app| !app.studio.jobs.is_running());
    let report = harness.state().studio.jobs.jobs()[0].report();
    assert_eq!(report.state, State::Stopped, "{report:?}");
}
