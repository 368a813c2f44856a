#pragma once

// As core/precompiled.h, for commands.

#include <ecorche/core/precompiled.h>

#include <CLI/CLI.hpp>
