#include <ecorche/core/contract.h>
#include <ecorche/studio/background.h>

#include <QString>

namespace ecorche::studio {

Background::~Background() {
  cancel();
  if (thread_.joinable()) thread_.join();
}

void Background::start(std::function<void(RunContext&)> work, std::function<void()> done) {
  EC_REQUIRE(!isBusy());
  if (thread_.joinable()) thread_.join();
  run_ = std::make_shared<RunContext>([this](std::string_view stage, double fraction) {
    const QString text = QString::fromUtf8(stage.data(), static_cast<qsizetype>(stage.size()));
    post_.post([this, text, fraction] { Q_EMIT progressed(text, fraction); });
  });
  thread_ = std::thread([this, run = run_, work = std::move(work), done = std::move(done)] {
    work(*run);
    post_.post([this, done] {
      run_.reset();
      done();
    });
  });
}

void Background::cancel() {
  if (run_) run_->cancel();
}

}  // namespace ecorche::studio
