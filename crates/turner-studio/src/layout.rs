//! Panels and where they are: tiles that the user drags, closes and opens again.

use egui_tiles::{Behavior, SimplificationOptions, Tile, TileId, Tiles, Tree, UiResponse};

use crate::panels;
use crate::studio::Studio;
use crate::viewport;

/// The table of panels: variant, title, function.
macro_rules! panels {
    ($($(#[doc = $doc:literal])+ $variant:ident, $title:literal, $show:path;)*) => {
        /// A panel.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Panel { $($(#[doc = $doc])+ $variant,)* }

        impl Panel {
            /// All panels.
            pub const ALL: &[Panel] = &[$(Panel::$variant,)*];

            /// Its title.
            pub fn title(self) -> &'static str {
                match self { $(Panel::$variant => $title,)* }
            }

            fn show(self, ui: &mut egui::Ui, studio: &mut Studio) {
                match self { $(Panel::$variant => $show(ui, studio),)* }
            }
        }
    };
}

panels! {
    /// The picture.
    Viewport, "View", viewport::show;
    /// The parts of the scene.
    Outliner, "Scene", panels::outliner::show;
    /// The keys of the selected part.
    Properties, "Properties", panels::properties::show;
    /// Steps that can be undone.
    History, "History", panels::history::show;
    /// Another camera or integrator beside the first.
    Second, "Second view", panels::second::show;
    /// Integrator, effects, anti-aliasing, light mixer.
    Effects, "Effects", panels::effects::show;
    /// The pixel under the pointer.
    Inspector, "Pixel", panels::inspector::show;
    /// The rays of a pixel.
    Rays, "Rays", panels::rays::show;
    /// Histogram and waveform.
    Scopes, "Scopes", panels::scopes::show;
    /// A kept picture.
    Compare, "Compare", panels::compare::show;
    /// What is wrong with the scene.
    Doctor, "Doctor", panels::doctor::show;
    /// Scenes to start from.
    Gallery, "Gallery", panels::gallery::show;
    /// Renders to files.
    Render, "Render", panels::render::show;
}

/// The arrangement at the first start.
pub(crate) fn initial() -> Tree<Panel> {
    let mut tiles = Tiles::default();
    let mut pane = |panel: Panel| tiles.insert_pane(panel);
    let view = pane(Panel::Viewport);
    let left = [Panel::Outliner, Panel::Gallery].map(&mut pane).to_vec();
    let above = [Panel::Properties, Panel::Effects, Panel::History, Panel::Render].map(&mut pane).to_vec();
    let below = [Panel::Inspector, Panel::Rays, Panel::Scopes, Panel::Compare, Panel::Doctor];
    let below = below.map(&mut pane).to_vec();
    let left = tiles.insert_tab_tile(left);
    let above = tiles.insert_tab_tile(above);
    let below = tiles.insert_tab_tile(below);
    let right = tiles.insert_vertical_tile(vec![above, below]);
    let view = tiles.insert_tab_tile(vec![view]);
    let root = tiles.insert_horizontal_tile(vec![left, view, right]);
    if let Some(Tile::Container(egui_tiles::Container::Linear(row))) = tiles.get_mut(root) {
        row.shares.set_share(left, 0.2);
        row.shares.set_share(view, 0.56);
        row.shares.set_share(right, 0.24);
    }
    Tree::new(egui::Id::unique("panels"), root, tiles)
}

/// Shows a panel: opens it, or brings it to the front of its tabs.
pub(crate) fn reveal(tree: &mut Tree<Panel>, panel: Panel) {
    if tree.tiles.find_pane(&panel).is_none() {
        let new = tree.tiles.insert_pane(panel);
        let beside = tree.tiles.find_pane(&Panel::Properties).or(tree.root());
        let parent = beside.and_then(|tile| tree.tiles.parent_of(tile)).or(tree.root());
        if let Some(parent) = parent {
            tree.move_tile_to_container(new, parent, usize::MAX, false);
        } else {
            tree.root = Some(new);
        }
    }
    tree.make_active(|_, tile| matches!(tile, Tile::Pane(pane) if *pane == panel));
}

struct Shown<'a> {
    studio: &'a mut Studio,
}

impl Behavior<Panel> for Shown<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _: TileId, pane: &mut Panel) -> UiResponse {
        let margin = if *pane == Panel::Viewport { 0 } else { 6 };
        egui::Frame::new().fill(ui.visuals().panel_fill).inner_margin(margin).show(ui, |ui| {
            pane.show(ui, self.studio);
            ui.allocate_space(ui.available_size().max(egui::Vec2::ZERO));
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Panel) -> egui::WidgetText {
        pane.title().into()
    }

    fn is_tab_closable(&self, tiles: &Tiles<Panel>, id: TileId) -> bool {
        tiles.get_pane(&id).is_some_and(|panel| *panel != Panel::Viewport)
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}

/// Shows all panels.
pub(crate) fn show(ui: &mut egui::Ui, tree: &mut Tree<Panel>, studio: &mut Studio) {
    tree.ui(&mut Shown { studio }, ui);
}
