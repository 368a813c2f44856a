#pragma once

#include <nlohmann/json.hpp>

#include "cli.h"

namespace ecorche::cli {

/// The form of every bench (DESIGN, command line): its name, the machine, and no case yet.
[[nodiscard]] nlohmann::ordered_json benchHeader(const char* bench);

void addBenchAdaptive(CLI::App& bench, Commands& commands);
void addBenchDrag(CLI::App& bench, Commands& commands);
void addBenchSettle(CLI::App& bench, Commands& commands);
void addBenchStrokes(CLI::App& bench, Commands& commands);
void addBenchValues(CLI::App& bench, Commands& commands);

}  // namespace ecorche::cli
