#pragma once

namespace ecorche::studio {

/// The program with the window. @return its exit code
int run(int argc, char** argv);

}  // namespace ecorche::studio
