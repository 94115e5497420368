#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint responses`: the measured impulse responses of Real Acoustic Fields, listed, or
/// compared with estimates.
void add_responses_command(CLI::App& app);

}  // namespace earpoint
