// SPDX-License-Identifier: Apache-2.0
import {defineConfig} from "vite";
import {viteSingleFile} from "vite-plugin-singlefile";

// One file, dist/index.html, that names no other: scripts and styles are in it.
export default defineConfig({
  base: "./",
  logLevel: "warn",
  build: {target: "es2022", cssCodeSplit: false, modulePreload: false, chunkSizeWarningLimit: 2000},
  plugins: [viteSingleFile({removeViteModuleLoader: true})],
});
