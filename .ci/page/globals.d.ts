// What the pages leave on the window for other scripts; see warpvec/viewer/assets/live.js.
interface Window {
  warpvecView: any;
  desk?: {
    fitAgain?: (text: string, locked: number[]) => void;
    save?: (text: string) => void;
    reshape?: (to: string, texts: string[]) => Promise<{ svg?: string; distance?: number; refused?: string }[]>;
    undo?: () => boolean;
    canUndo?: () => boolean;
    isKept?: () => boolean;
  };
}
