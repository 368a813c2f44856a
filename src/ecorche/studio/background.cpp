#include <ecorche/core/contract.h>
#include <ecorche/studio/background.h>

#include <QMetaObject>
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
    QMetaObject::invokeMethod(
        this, [this, text, fraction] { Q_EMIT progressed(text, fraction); }, Qt::QueuedConnection);
  });
  thread_ = std::thread([this, run = run_, work = std::move(work), done = std::move(done)] {
    work(*run);
    QMetaObject::invokeMethod(
        this,
        [this, done] {
          run_.reset();
          done();
        },
        Qt::QueuedConnection);
  });
}

void Background::cancel() {
  if (run_) run_->cancel();
}

}  // namespace ecorche::studio
