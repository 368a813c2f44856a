#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/commands.h>

#include <string>
#include <string_view>
#include <vector>

namespace ecorche::model {

/// One line: a verb, then words, then key=value. Words with blanks stand in double quotes.
///   curve.add biceps 0.02,0.31,0.05 0.03,0.24,0.06 tissue=1.2 start=bone:scapula
/// parseCommand(formatCommand(c)) == c to the last bit.
[[nodiscard]] std::string formatCommand(const Command& command);

/// @errors CommandSyntax, with the column of the word at fault
[[nodiscard]] Result<Command> parseCommand(std::string_view line);

struct ScriptLine {
  Command command;
  int line = 0;  ///< from 1
};

/// One command a line; empty lines and lines that start with # are skipped.
/// @param file  for messages
/// @errors CommandSyntax with line and column; nothing is returned if any line is wrong
[[nodiscard]] Result<std::vector<ScriptLine>> parseScript(std::string_view text,
                                                          const std::string& file);

/// How each command is written, one line each, for `ecorche run --help` and the manual:
/// "point.move MUSCLE CURVE POINT X,Y,Z".
[[nodiscard]] std::vector<std::string> commandUsages();

}  // namespace ecorche::model
