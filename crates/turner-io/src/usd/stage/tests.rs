//! Composition. The expected values are those of OpenUSD 26.11.

use std::collections::BTreeMap;

use super::*;

/// Files in memory.
struct Memory(BTreeMap<&'static str, &'static str>);

impl Source for Memory {
    fn resolve(&self, _: &str, asset: &str) -> Result<String, String> {
        self.0.get_key_value(asset).map(|(name, _)| (*name).to_owned()).ok_or_else(|| format!("no {asset}"))
    }
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        Ok(self.0[name].as_bytes().to_vec())
    }
}

const MODEL: &str = r#"#usda 1.0
( defaultPrim = "Model" )
class "_class_Model" { float inherited = 1; float local = 1; }
def Xform "Model" (
    inherits = </_class_Model>
    variantSets = ["size", "color"]
    variants = { string size = "small" }
)
{
    float reference = 1
    float payload = 1
    float local = 2
    rel target = </Model/Part>
    rel far = </Elsewhere>
    def "Part" { float x.timeSamples = { 0: 0, 10: 10 }; }
    variantSet "size" = {
        "small" { float scale = 1; }
        "large" {
            float scale = 5
            def "Extra" {}
        }
    }
    variantSet "color" = { "red" { float color = 1; } }
}
def "Elsewhere" {}
"#;

const ROOT: &str = r#"#usda 1.0
( subLayers = [@strong.usda@, @weak.usda@ (offset = 100)] )
class "_class_Model" { float inherited = 9; }
def "A" ( references = @model.usda@ (offset = 5; scale = 2) ) {}
def "B" (
    prepend payload = @model.usda@
    variants = { string size = "large" }
)
{
    float reference = 7
    over "Part" { float y = 1; }
}
def "C" ( references = @model.usda@</Model/Part> ) {}
def "D" ( specializes = </S>; references = </R> ) {}
def "S" { float a = 1; float b = 1; }
def "R" { float a = 2; }
def "N" ( references = @none.usda@ ) {}
def "Time" { float x.timeSamples = { 0: 1, 10: 2 }; float held.timeSamples = { 0: None }; token t.timeSamples = { 0: "a", 10: "b" }; }
"#;

const STRONG: &str = r#"#usda 1.0
over "Layers" { float a = 1; }
over "Time" ( delete apiSchemas = ["X"] ) {}
"#;

const WEAK: &str = r#"#usda 1.0
def "Layers" { float a = 2; float b = 2; float x.timeSamples = { 0: 1, 10: 2 }; }
"#;

fn with<T>(time: f64, of: impl Fn(&Stage<'_>) -> T) -> T {
    let files = [("root.usda", ROOT), ("model.usda", MODEL), ("strong.usda", STRONG), ("weak.usda", WEAK)];
    let memory = Memory(files.into_iter().collect());
    let mut stage = Stage::open(&memory, "root.usda", ROOT.into()).unwrap();
    stage.time = time;
    of(&stage)
}

fn number(path: &str, name: &str, time: f64) -> Option<f64> {
    with(time, |stage| {
        let prim = stage.prim_at(path).unwrap()?;
        stage.value(&prim, name).unwrap().and_then(|v| v.real())
    })
}

#[test]
fn stronger_opinions_win() {
    // Local, then those of classes in the referring file, then of the reference.
    assert_eq!(number("/B", "reference", 0.0), Some(7.0));
    assert_eq!(number("/A", "reference", 0.0), Some(1.0));
    assert_eq!(number("/A", "inherited", 0.0), Some(9.0));
    assert_eq!(number("/A", "local", 0.0), Some(2.0));
    // What is specialized is weaker than what is referred to.
    assert_eq!((number("/D", "a", 0.0), number("/D", "b", 0.0)), (Some(2.0), Some(1.0)));
    assert_eq!((number("/Layers", "a", 0.0), number("/Layers", "b", 0.0)), (Some(1.0), Some(2.0)));
}

#[test]
fn variants_are_selected_by_the_strongest() {
    assert_eq!((number("/A", "scale", 0.0), number("/B", "scale", 0.0)), (Some(1.0), Some(5.0)));
    // No selection, no variant.
    assert_eq!(number("/A", "color", 0.0), None);
    with(0.0, |stage| {
        assert!(stage.prim_at("/B/Extra").unwrap().is_some());
        assert!(stage.prim_at("/A/Extra").unwrap().is_none());
        let prim = stage.prim_at("/B").unwrap().unwrap();
        assert_eq!(stage.names(&prim, "primChildren").unwrap(), ["Extra", "Part"]);
    });
}

#[test]
fn times_pass_the_offsets_of_references_and_sublayers() {
    // The time of the model is (t − 5) / 2.
    assert_eq!(number("/A/Part", "x", 15.0), Some(5.0));
    assert_eq!(number("/B/Part", "x", 4.0), Some(4.0));
    assert_eq!(number("/C", "x", 4.0), Some(4.0));
    assert_eq!(number("/Layers", "x", 105.0), Some(1.5));
    assert_eq!(
        [-5.0, 0.0, 2.5, 10.0, 20.0].map(|t| number("/Time", "x", t).unwrap()),
        [1.0, 1.0, 1.25, 2.0, 2.0]
    );
    assert_eq!(number("/Time", "held", 0.0), None);
    with(9.0, |stage| {
        let prim = stage.prim_at("/Time").unwrap().unwrap();
        assert_eq!(stage.value(&prim, "t").unwrap(), Some(Value::Text("a".into())));
    });
}

#[test]
fn targets_are_paths_of_the_stage() {
    with(0.0, |stage| {
        let prim = stage.prim_at("/A").unwrap().unwrap();
        assert_eq!(stage.targets(&prim, "target", "targetPaths").unwrap(), ["/A/Part"]);
        // Outside what is referred to.
        assert!(stage.targets(&prim, "far", "targetPaths").unwrap().is_empty());
    });
}

#[test]
fn what_is_missing_is_reported() {
    with(0.0, |stage| {
        stage.prim_at("/N").unwrap().unwrap();
        assert_eq!(stage.problems(), ["no none.usda"]);
    });
}
