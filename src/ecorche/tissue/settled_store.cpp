#include <ecorche/core/contract.h>
#include <ecorche/tissue/settled_store.h>

#include <algorithm>
#include <set>

namespace ecorche::tissue {

namespace {

// Each thing once, whoever shares it
class Weighing {
 public:
  void add(const Settling::Settled& settled) {
    bytes_ += sizeof(double) *
              static_cast<std::size_t>(settled.fields.values.size() + settled.fat.size());
    if (settled.factor && isNew(settled.factor.get())) bytes_ += settled.factor->bytes();
    if (settled.ground) add(*settled.ground);
    for (const OwnEquations& own : settled.own) {
      if (!own.ground || !isNew(own.ground.get())) continue;
      bytes_ += own.ground->medium.size() * sizeof(OwnGround::Tensor) +
                static_cast<std::size_t>(own.ground->spread.size()) * sizeof(float);
      add(*own.ground->ground);
    }
  }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::set<const void*> seen_;
  std::size_t bytes_ = 0;

  bool isNew(const void* thing) { return seen_.insert(thing).second; }
  void add(const DragGround& ground) {
    if (!isNew(&ground)) return;
    bytes_ += ground.K.size() * sizeof(double);
    if (!ground.single) bytes_ += ground.tree.copiedBytes();
    for (const mesh::SingleCholesky* factor = ground.single.get(); factor && isNew(factor);
         factor = factor->before().get())
      bytes_ += factor->bytes();
  }
};

}  // namespace

SettledStore::Result SettledStore::find(const std::vector<CurveTissue>& tissues,
                                        const TissueOptions& options) {
  const auto is = std::ranges::find_if(
      kept_, [&](const Kept& k) { return k.tissues == tissues && k.options == options; });
  if (is == kept_.end()) return nullptr;
  kept_.splice(kept_.begin(), kept_, is);
  return kept_.front().settled;
}

void SettledStore::keep(const std::vector<CurveTissue>& tissues, const TissueOptions& options,
                        Result settled) {
  EC_REQUIRE(find(tissues, options) == nullptr);
  kept_.push_front({tissues, options, std::move(settled)});
  while (!kept_.empty() && bytes() > most_) kept_.pop_back();
}

std::size_t SettledStore::bytes() const {
  Weighing all;
  for (const Kept& kept : kept_) all.add(*kept.settled);
  return all.bytes();
}

}  // namespace ecorche::tissue
