#include <ecorche/studio/app.h>

int main(int argc, char** argv) { return ecorche::studio::run(argc, argv); }
