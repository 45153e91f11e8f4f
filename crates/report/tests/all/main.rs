//! The page, its figures and the map.

mod archipelago;
mod drawing;
mod figures;
mod interactive;
mod map;
mod map_document;
mod measured;
mod mock;
mod mock_plan;
mod page;
mod trajectory;
mod trajectory_map;
