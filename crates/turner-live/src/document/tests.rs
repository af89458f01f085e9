use super::*;
use turner::shape::{ShapeDesc, SphereDesc};

fn with_ball() -> Document {
    let mut desc = SceneDesc::default();
    desc.objects.push(turner::ObjectDesc::new(ShapeDesc::Sphere(SphereDesc::default())));
    Document::of(desc, "ball".into(), PathBuf::from("."))
}

fn radius(document: &Document) -> f64 {
    match &document.desc().objects[0].content {
        turner::description::ObjectContent::Shape(ShapeDesc::Sphere(ball)) => ball.radius,
        other => panic!("{other:?}"),
    }
}

#[test]
fn undo_all_is_the_start_and_redo_all_the_end() {
    let mut document = with_ball();
    let start = Arc::clone(document.desc());
    for i in 1..=5 {
        let value = Data::Number(f64::from(i));
        document.set("Radius", None, &[("object.0.radius".into(), value)]).unwrap();
    }
    let end = Arc::clone(document.desc());
    assert_eq!(document.steps().0.len(), 4, "a value that stays the same is no step");
    while document.undo().is_some() {}
    assert!(Arc::ptr_eq(document.desc(), &start) && !document.is_changed());
    while document.redo().is_some() {}
    assert!(Arc::ptr_eq(document.desc(), &end));
}

#[test]
fn a_drag_is_one_step() {
    let mut document = with_ball();
    for i in 2..20 {
        let value = Data::Number(f64::from(i));
        document.set("Radius", Some("radius"), &[("object.0.radius".into(), value)]).unwrap();
    }
    document.end_gesture();
    document.set("Radius", Some("radius"), &[("object.0.radius".into(), Data::Number(0.5))]).unwrap();
    assert_eq!(document.steps().0.len(), 2);
    document.undo();
    assert_eq!(radius(&document), 19.0);
    document.undo();
    assert_eq!(radius(&document), 1.0);
}

#[test]
fn a_value_out_of_range_changes_nothing() {
    let mut document = with_ball();
    let before = Arc::clone(document.desc());
    let error = document.set("Radius", None, &[("object.0.radius".into(), Data::Number(-1.0))]).unwrap_err();
    assert!(error.message.contains("radius"), "{}", error.message);
    assert!(Arc::ptr_eq(document.desc(), &before));
}

#[test]
fn unsaved_work_is_found_again() {
    let root = tempfile::tempdir().unwrap();
    let mut document = with_ball();
    document.set("Radius", None, &[("object.0.radius".into(), Data::Number(3.0))]).unwrap();
    let mut recovery = Recovery::new(root.path());
    recovery.keep(&document, true);
    recovery.finish();
    // The session of this process is not offered while it runs; another process finds it.
    assert!(recovered(root.path()).is_empty());
    let folder = std::fs::read_dir(root.path()).unwrap().next().unwrap().unwrap().path();
    let about = std::fs::read_to_string(folder.join("about.json")).unwrap();
    let other = about.replace(&std::process::id().to_string(), "4294967295");
    std::fs::write(folder.join("about.json"), other).unwrap();
    let found = recovered(root.path());
    assert_eq!(found.len(), 1);
    let again = Document::open(&found[0].scene).unwrap();
    again.desc().same_scene(document.desc()).unwrap();
    found[0].discard();
    assert!(recovered(root.path()).is_empty());
}
