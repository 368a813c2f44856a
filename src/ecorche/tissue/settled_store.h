#pragma once

#include <ecorche/tissue/settling.h>

#include <cstddef>
#include <list>
#include <memory>
#include <vector>

namespace ecorche::tissue {

/// Results of settling on one domain that a hand may come back to: an undo finds what was there, to
/// the last bit and without solving.
///
/// What equations and factors of several results have in common is held once. Above a number of
/// bytes those go that nobody has asked for longest.
class SettledStore {
 public:
  /// @param mostBytes  results that alone are larger are not kept
  explicit SettledStore(std::size_t mostBytes) : most_(mostBytes) {}

  using Result = std::shared_ptr<const Settling::Settled>;

  /// The result for exactly these tissues and options; null: not kept.
  [[nodiscard]] Result find(const std::vector<CurveTissue>& tissues, const TissueOptions& options);
  /// @pre  none is kept for these
  void keep(const std::vector<CurveTissue>& tissues, const TissueOptions& options, Result settled);

  [[nodiscard]] std::size_t size() const { return kept_.size(); }
  [[nodiscard]] std::size_t bytes() const;  ///< of all of them together

 private:
  struct Kept {
    std::vector<CurveTissue> tissues;
    TissueOptions options;
    Result settled;
  };
  std::size_t most_ = 0;
  std::list<Kept> kept_;  // asked for last: first
};

}  // namespace ecorche::tissue
