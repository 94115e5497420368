#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint view`: the picture that a camera takes of a scene, its depth and its mask.
void add_view_command(CLI::App& app);

}  // namespace earpoint
