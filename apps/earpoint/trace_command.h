#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint trace`: the impulse response from one place to another.
void add_trace_command(CLI::App& app);

}  // namespace earpoint
